"""The periodic state of the implicit model: run until it repeats, beside the exact model's."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from ..model.checks import check_number
from ..model.errors import NotConverged
from ..model.gait import Gait
from ..model.ground import Ground
from ..model.robot import Robot
from ..periodic.steady import steady_gait
from .related_scenes import largest_stable_step_s
from .run import Run
from .scene import Scene
from .simulate import simulate

_MOST_CYCLES = 4096
_STEPS_A_CYCLE = 1000


@dataclass(frozen=True, slots=True)
class SteadySprings:
    """Hold the periodic state of a gait by the implicit model (Eqs. 51-56).

    speed_m_s (m/s), power_w, abs_power_w, positive_power_w (W): as in Steady. error_estimate: of
    the speed, relative: how much it still changes from cycle to cycle, and the time steps.
    modelling_error: of the speed, relative to the exact model's, signed. cycles: run until then.
    """

    speed_m_s: float
    power_w: float
    abs_power_w: float
    positive_power_w: float
    error_estimate: float
    modelling_error: float
    cycles: int

    def to_dict(self) -> dict[str, Any]:
        """Return the figures as plain numbers, for JSON."""
        return asdict(self)


def _cycle_scene(scene: Scene) -> Scene:
    """Return the scene with a stable step that divides a cycle."""
    period = scene.gait.period_s
    most = min(period / _STEPS_A_CYCLE, largest_stable_step_s(scene) / 2)
    steps = 2 * math.ceil(period / most / 2)
    return replace(scene, dt_s=period / steps, record_every=steps)


def _settled(scene: Scene, rtol: float, floor_m_s: float) -> tuple[Run, float, float, int]:
    """Return the last run, its mean speed, how much that still varies, and the cycles it took."""
    cycles, count, spread = 0, 8, math.inf
    while cycles < _MOST_CYCLES:
        run = simulate(replace(scene, duration_s=count * scene.gait.period_s))
        cycles += count
        late = run.mean_speed_m_s(scene.gait.period_s)[count // 2 :]
        spread = float(np.ptp(late))
        if spread <= rtol * max(late.mean(), floor_m_s):
            return run, float(late.mean()), spread, cycles
        scene, count = replace(scene, start=run.state()), min(2 * count, 256)
    raise NotConverged(
        f"after {cycles} cycles the speed still varies by {spread:.1g} m/s from cycle to cycle; "
        f"ask for a larger rtol than {rtol:g}, or more damping than "
        f"{scene.joint_damping_n_s_m:g} N s/m"
    )


def steady_springs(
    robot: Robot,
    ground: Ground,
    gait: Gait,
    *,
    joint_stiffness_n_m: float = 1e3,
    joint_damping_n_s_m: float = 1.0,
    rtol: float = 1e-4,
) -> SteadySprings:
    """Run the implicit model until it repeats, and compare it with the exact model's speed.

    joint_stiffness_n_m in N/m, joint_damping_n_s_m in N s/m. Starts from the exact periodic state
    on the slow manifold and follows it until the speed of a cycle varies by less than rtol,
    relative (1e-9 to 0.1). Dry friction sticks (method "nonsmooth"). Raises BadInput, and
    NotConverged after 4096 cycles.
    """
    check_number("rtol", rtol, 1e-9, 0.1)
    exact = steady_gait(robot, ground, gait, powers=False)
    scene = _cycle_scene(
        Scene(
            robot, ground, gait, formulation="implicit", start="steady",
            joint_stiffness_n_m=joint_stiffness_n_m, joint_damping_n_s_m=joint_damping_n_s_m,
            method="rk4" if ground.smooth else "nonsmooth",
        )
    )  # fmt: skip
    floor = 1e-4 * gait.omega_rad_s * robot.links * robot.link_length_m
    run, speed, spread, cycles = _settled(scene, rtol, floor)
    once = replace(scene, start=run.state(), duration_s=gait.period_s)
    last = simulate(replace(once, record=("joints",), record_every=1))
    finer = simulate(replace(once, dt_s=scene.dt_s / 2, record_every=2 * scene.every))
    steps = (
        abs(last.travel_m - finer.travel_m) / gait.period_s * (16 / 15 if ground.smooth else 2.0)
    )
    power = last.joint_power_w[1:]  # a period's samples: the mean is as good as the steps
    return SteadySprings(
        speed, float(power.sum(axis=1).mean()), float(np.abs(power).sum(axis=1).mean()),
        float(np.maximum(power, 0).sum(axis=1).mean()), (spread + steps) / max(speed, floor),
        speed / max(exact.speed_m_s, floor) - 1, cycles,
    )  # fmt: skip
