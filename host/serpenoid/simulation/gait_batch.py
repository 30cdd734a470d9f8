"""Many gaits of one scene at once: the implicit formulation, lanes of the processor over gaits."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..model.checks import STARTS, check_kind
from ..model.core_model import friction_numbers
from ..model.errors import BadInput
from ..model.gait import Gait
from ..model.kinematics import joint_motion
from ..model.link_state import LinkState
from .methods import OwnChoice
from .scene import Scene
from .stability import check_step
from .starts import start_state

Array = NDArray[np.float64]
_RUNS_AS = {
    "formulation": "implicit", "drive": "angle", "method": "rk4", "limp": (), "locked": {},
    "incline_rad": 0.0, "record": (),
}  # fmt: skip
_AT_ONCE = 64  # gaits from one Ctrl-C to the next


@dataclass(frozen=True, slots=True)
class GaitRuns:
    """Hold the end of a run of every gait: arrays (G,) over gaits, (G, n) over gaits and links.

    t_s: the time of the state, the scene's duration where `diverged` is False; where it is True,
    the last time at which the state was seen to be finite, at most 64 steps before it left the
    finite numbers. x_m, y_m: link centres, m, theta_rad: angles, rad, vx_m_s, vy_m_s, m/s,
    omega_rad_s, rad/s: their rates, ground frame. displacement_m (G, 2): way of the centre of mass
    since the start, m. speed_m_s: its length over t_s, m/s (0 where t_s is 0): the mean of the
    whole run, its start included, not that of the periodic state. All finite.
    """

    scene: Scene
    gaits: tuple[Gait, ...]
    diverged: NDArray[np.bool_]
    t_s: Array
    x_m: Array
    y_m: Array
    theta_rad: Array
    vx_m_s: Array
    vy_m_s: Array
    omega_rad_s: Array
    displacement_m: Array
    speed_m_s: Array

    def state(self, index: int) -> LinkState:
        """Return the end state of all links under one gait."""
        return LinkState.row(self, index)


def _check(scene: Scene, gaits: Sequence[Gait]) -> None:
    for name, wanted in _RUNS_AS.items():
        value = getattr(scene, name)
        if value != wanted:
            raise BadInput(
                f"{name} is {value!r}; simulate_gaits runs {wanted!r} alone, take simulate for "
                "each gait instead"
            )
    if isinstance(scene.start, LinkState):
        raise BadInput(
            "start is a LinkState, which has the joint angles of one gait; simulate_gaits takes "
            f"one of {', '.join(STARTS)}"
        )
    if not gaits or not all(isinstance(gait, Gait) for gait in gaits):
        raise BadInput(f"gaits is {gaits!r:.80}; it must be a list of at least one Gait")
    if any(gait.joint_gain or gait.joint_shift_rad for gait in gaits):
        raise BadInput(
            "a gait has joint_gain or joint_shift_rad; simulate_gaits runs gaits without, take "
            "simulate for each gait instead"
        )


def batch_scene(scene: Scene) -> _core.BatchScene:
    """Hand what all gaits share to the compiled core."""
    robot, ground = scene.robot, scene.ground
    return _core.BatchScene(
        robot.links, robot.link_mass_kg, robot.link_length_m / 2, robot.inertia_kg_m2,
        *friction_numbers(ground), scene.joint_stiffness_n_m, scene.joint_damping_n_s_m,
        scene.smoothing_m_s,
    )  # fmt: skip


def batch_state(state: LinkState) -> Array:
    """Return x, y, vx, vy of all links, then theta and omega of link 1, (4 n + 2,)."""
    tail = [state.theta_rad[0], state.omega_rad_s[0]]
    return np.concatenate([state.x_m, state.y_m, state.vx_m_s, state.vy_m_s, tail])


def gait_rows(gaits: Sequence[Gait]) -> Array:
    """Return alpha, beta, omega, offset of every gait, (G, 4)."""
    return np.array([[g.alpha_rad, g.beta_rad, g.omega_rad_s, g.offset_rad] for g in gaits])


def _angles(gaits: Sequence[Gait], t_s: Array, tail: Array, links: int) -> tuple[Array, Array]:
    """Return theta and omega of all links, (G, n), from those of link 1, (G, 2), and Eq. 57."""
    moves = [joint_motion(gait, links - 1, t) for gait, t in zip(gaits, t_s, strict=True)]
    theta = np.cumsum([move.angle_rad for move in moves], axis=1)
    omega = np.cumsum([move.rate_rad_s for move in moves], axis=1)
    to_all = ((0, 0), (1, 0))
    return tail[:, :1] + np.pad(theta, to_all), tail[:, 1:] + np.pad(omega, to_all)


def simulate_gaits(scene: Scene, gaits: Sequence[Gait]) -> GaitRuns:
    """Run a scene under every gait instead of its own and return where each of them ends.

    formulation "implicit", drive "angle", method "rk4" (Eqs. 51-56), same ground, step and
    duration for all, the level, all joints sound; each gait starts as the scene's `start` says. A
    gait's numbers are the same bits whichever gaits run beside it. A gait that leaves the finite
    numbers is marked in `diverged` and stops no other. Raises StepTooLarge, before anything runs,
    when dt_s is too long under any gait, and BadInput.
    """
    check_kind("scene", scene, Scene, "scene, gaits")
    if isinstance(scene.method, OwnChoice):
        scene = replace(scene, method="rk4")
    _check(scene, gaits)
    scenes = [replace(scene, gait=gait) for gait in gaits]
    for one in scenes:
        check_step(one)
    starts = np.array([batch_state(start_state(one)) for one in scenes])
    rows, n = gait_rows(gaits), scene.robot.links
    parts = [
        _core.run_batch(
            batch_scene(scene), rows[i : i + _AT_ONCE], starts[i : i + _AT_ONCE], scene.dt_s,
            scene.duration_s, scene.steps, _core.instruction_sets()[0], True,
        )
        for i in range(0, len(gaits), _AT_ONCE)
    ]  # fmt: skip
    ends, t_s = np.concatenate([p[0] for p in parts]), np.concatenate([p[1][:, 0] for p in parts])
    x, y, vx, vy = np.split(ends[:, : 4 * n], 4, axis=1)
    theta, omega = _angles(gaits, t_s, ends[:, 4 * n :], n)
    way = np.stack([x.mean(axis=1), y.mean(axis=1)], axis=1)
    way -= np.stack([starts[:, :n].mean(axis=1), starts[:, n : 2 * n].mean(axis=1)], axis=1)
    speed = np.hypot(*way.T) / np.where(t_s > 0, t_s, np.inf)
    diverged = t_s < scene.duration_s
    return GaitRuns(
        scene, tuple(gaits), diverged, t_s, x, y, theta, vx, vy, omega, way, speed
    )  # fmt: skip
