"""The simulator as a Gymnasium environment: torques in, the snake's pose and speed out."""

from __future__ import annotations

import math
from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from ..model.gait import Gait
from ..model.ground import Ground
from ..model.link_state import LinkState
from ..model.robot import Robot
from ..simulation.scene import Scene
from ..simulation.simulate import simulate

STRAIGHT = Gait(0.0, 0.0, 1.0)  # what a scene driven by torques takes no notice of
FOLDED_RAD = 0.9 * math.pi


class SnakeEnv(gymnasium.Env[NDArray[np.float32], NDArray[np.float32]]):
    """Crawl as far as possible along x for little work, by the torque of every joint.

    Action: (n-1,) in -1..1, times torque_nm; above 0 makes the joint's angle grow. Observation,
    (2 n + 3,): cosine and sine of the mean heading, velocity of the centre of mass (m/s) and mean
    turning rate (rad/s), joint angles (rad) and rates (rad/s), from the tail. Reward: metres along
    x, less work_cost_m_j times the joints' positive work. An episode ends when a joint folds beyond
    FOLDED_RAD, and is cut off at episode_s. Dry friction is smoothed over smoothing_m_s.
    """

    metadata = {"render_modes": []}  # noqa: RUF012 (Gymnasium's own form)

    def __init__(
        self,
        robot: Robot | None = None,
        ground: Ground | None = None,
        *,
        torque_nm: float = 0.02,
        control_s: float = 0.02,
        episode_s: float = 10.0,
        work_cost_m_j: float = 1.0,
        smoothing_m_s: float = 1e-3,
    ):
        self.robot = robot or Robot(6, 0.0756, 0.076)
        self.ground = ground or Ground.whole_body(6, ct=0.084, cn=1.2, ft0=0.0, fn0=0.0)
        self.torque_nm, self.control_s, self.episode_s = torque_nm, control_s, episode_s
        self.work_cost_m_j = work_cost_m_j
        self.smoothing_m_s = 0.0 if self.ground.smooth else smoothing_m_s
        n = self.robot.links
        self.action_space = spaces.Box(-1.0, 1.0, (n - 1,), np.float32)
        self.observation_space = spaces.Box(-np.inf, np.inf, (2 * n + 3,), np.float32)
        self._state, self._t_s = self._start(np.zeros(n)), 0.0

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Lay the snake down at rest, each link within 0.1 rad of the x axis."""
        super().reset(seed=seed, options=options)
        self._state = self._start(self.np_random.uniform(-0.1, 0.1, self.robot.links))
        self._t_s = 0.0
        return self._observation(), {}

    def step(
        self, action: NDArray[np.float32]
    ) -> tuple[NDArray[np.float32], float, bool, bool, dict[str, Any]]:
        """Hold the torques for control_s."""
        torque = -self.torque_nm * np.clip(np.asarray(action, dtype=float), -1.0, 1.0)
        before = self._state
        run = simulate(Scene(
            self.robot, self.ground, STRAIGHT, drive="torque", torque=torque, start=before,
            method="rk4", dt_s=self.control_s / 20, duration_s=self.control_s, record_every=20,
            smoothing_m_s=self.smoothing_m_s, record=("energy",),
        ))  # fmt: skip
        self._state = run.state()
        self._t_s += self.control_s
        way_m, work_j = (
            float(self._state.x_m.mean() - before.x_m.mean()),
            float(run.energy_j[-1, 6]),
        )
        folded = bool(np.abs(np.diff(self._state.theta_rad)).max() > FOLDED_RAD)
        late = self._t_s >= self.episode_s - 1e-9
        told = {"way_m": way_m, "work_j": work_j}
        return self._observation(), way_m - self.work_cost_m_j * work_j, folded, late, told

    def _start(self, theta: NDArray[np.float64]) -> LinkState:
        n = self.robot.links
        return LinkState.joined(self.robot, [0.0, 0.0, *theta], np.zeros(n + 2))

    def _observation(self) -> NDArray[np.float32]:
        s = self._state
        heading = math.atan2(np.sin(s.theta_rad).mean(), np.cos(s.theta_rad).mean())
        moving = [s.vx_m_s.mean(), s.vy_m_s.mean(), s.omega_rad_s.mean()]
        seen = [math.cos(heading), math.sin(heading), *moving,
                *np.diff(s.theta_rad), *np.diff(s.omega_rad_s)]  # fmt: skip
        return np.array(seen, dtype=np.float32)
