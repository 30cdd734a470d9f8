"""The simulator as a Gymnasium environment: torques in, the snake's pose and speed out."""

from __future__ import annotations

import math
from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from ..model.checks import check_choice, check_number
from ..model.core_model import check_parts
from ..model.gait import Gait
from ..model.ground import Ground
from ..model.link_state import LinkState
from ..model.robot import Robot
from ..model.vectors import finite_vector
from ..simulation.scene import Scene
from ..simulation.simulate import simulate
from .picture import picture

STRAIGHT = Gait(0.0, 0.0, 1.0)  # what a scene driven by torques takes no notice of
FOLDED_RAD = 0.9 * math.pi
MOST_STEPS = 1_000_000  # of an action


class SnakeEnv(gymnasium.Env[NDArray[np.float32], NDArray[np.float32]]):
    """Crawl as far as possible along x for little work, by the torque of every joint.

    Importing this module registers it: `gymnasium.make("serpenoid/Snake-v0")`, or in one line
    `gymnasium.make("serpenoid.exchange.gym_env:serpenoid/Snake-v0")`. Action: (n-1,) in -1..1,
    times torque_nm; above 0 makes the joint's angle grow. Observation, (2 n + 3,): cosine and sine
    of the mean heading, velocity of the centre of mass (m/s) and mean turning rate (rad/s), joint
    angles (rad) and rates (rad/s), from the tail. Reward: metres along x, less work_cost_m_j times
    the joints' positive work. An episode ends when a joint folds beyond FOLDED_RAD, and is cut off
    at episode_s.

    Parameters
    ----------
    robot, ground
        What crawls, and on what; six links of the 2005 robot unless given.
    torque_nm
        Torque of an action of 1, N m.
    control_s, dt_s
        How long an action lasts, s, and the longest step of the simulation, s.
    episode_s
        Length of an episode, s.
    work_cost_m_j
        Price of the joints' positive work, m/J.
    render_mode
        `rgb_array`: render() returns a picture; None: nothing.

    Raises
    ------
    BadInput
        An argument is out of range.
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": 50}  # noqa: RUF012

    def __init__(
        self,
        robot: Robot | None = None,
        ground: Ground | None = None,
        *,
        torque_nm: float = 0.02,
        control_s: float = 0.02,
        episode_s: float = 10.0,
        work_cost_m_j: float = 1.0,
        dt_s: float = 1e-3,
        render_mode: str | None = None,
    ):
        self.robot = Robot(6, 0.0756, 0.076) if robot is None else robot
        self.ground = (
            Ground.whole_body(6, ct=0.084, cn=1.2, ft0=0.0, fn0=0.0) if ground is None else ground
        )
        check_parts(self.robot, self.ground)
        self.torque_nm = check_number("torque_nm", torque_nm, 0.0, open_low=True)
        self.control_s = check_number("control_s", control_s, 0.0, open_low=True)
        self.episode_s = check_number("episode_s", episode_s, 0.0, open_low=True)
        self.work_cost_m_j = check_number("work_cost_m_j", work_cost_m_j, 0.0)
        dt_s = check_number("dt_s", dt_s, self.control_s / MOST_STEPS, open_low=True)
        self.steps = math.ceil(self.control_s / dt_s - 1e-9)  # of an action
        if render_mode is not None:
            check_choice("render_mode", render_mode, ("rgb_array",))
        self.render_mode = render_mode
        self.metadata = type(self).metadata | {"render_fps": max(1, round(1 / self.control_s))}
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
        """Hold the torques for control_s; raise BadInput for an action that is no such numbers."""
        wanted = finite_vector("action", action, self.robot.links - 1)
        torque = -self.torque_nm * np.clip(wanted, -1.0, 1.0)
        before = self._state
        run = simulate(
            Scene(
                self.robot,
                self.ground,
                STRAIGHT,
                drive="torque",
                torque=torque,
                start=before,
                dt_s=self.control_s / self.steps,
                duration_s=self.control_s,
                record_every=self.steps,
                record=("energy",),
            )
        )
        self._state = run.state()
        self._t_s += self.control_s
        way_m, work_j = (
            float(self._state.x_m.mean() - before.x_m.mean()),
            float(run.energy_j[-1, 6]),
        )
        folded = bool(np.abs(np.diff(self._state.theta_rad)).max() > FOLDED_RAD)
        late = self._t_s >= self.episode_s - 1e-9
        info = {"way_m": way_m, "work_j": work_j}
        return self._observation(), way_m - self.work_cost_m_j * work_j, folded, late, info

    def render(self) -> NDArray[np.uint8] | None:  # type: ignore[override]
        """Return the snake from above as (300, 600, 3) pixels, the camera beside it."""
        return picture(self.robot, self._state) if self.render_mode == "rgb_array" else None

    def _start(self, theta: NDArray[np.float64]) -> LinkState:
        n = self.robot.links
        return LinkState.joined(self.robot, [0.0, 0.0, *theta], np.zeros(n + 2))

    def _observation(self) -> NDArray[np.float32]:
        s = self._state
        heading = math.atan2(np.sin(s.theta_rad).mean(), np.cos(s.theta_rad).mean())
        moving = [s.vx_m_s.mean(), s.vy_m_s.mean(), s.omega_rad_s.mean()]
        observed = [
            math.cos(heading),
            math.sin(heading),
            *moving,
            *np.diff(s.theta_rad),
            *np.diff(s.omega_rad_s),
        ]
        return np.array(observed, dtype=np.float32)


gymnasium.register(id="serpenoid/Snake-v0", entry_point=f"{__name__}:SnakeEnv")
