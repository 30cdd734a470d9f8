"""The periodic state of the implicit model: run until it repeats, beside the exact model's."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from ..base.checks import check_number
from ..base.errors import BadInput, NotConverged
from ..base.rows import Result, Row, detail, two_digits
from ..base.vectors import Array
from ..model.gait import Gait
from ..model.ground import Ground
from ..model.robot import Robot
from ..periodic.steady import speed_floor_m_s, steady_gait
from .accuracy import SAFETY, with_shorter_steps
from .run import ENERGY_COLUMNS, Run
from .scene import Scene
from .simulate import simulate
from .stability import largest_stable_step_s


@dataclass(frozen=True, slots=True)
class SteadySprings(Result):
    """Hold the periodic state of a gait by the implicit model (Eqs. 51-56).

    Attributes
    ----------
    speed_m_s
        As in Steady, m/s.
    power_w
        Net mean of P = -sum T_i phi_i', W.
    abs_power_w
        Mean of sum |P_i|, W.
    positive_power_w
        Mean of sum max(P_i, 0), W.
    error_estimate
        Of the speed, relative: what later cycles will still change, and the time steps.
    power_error_w
        Error of power_w, W.
    positive_power_error_w
        Error of positive_power_w, W.
    modelling_error
        Of the speed, relative to the exact model's, signed.
    cycles
        Run until then.

    Examples
    --------
    >>> robot = sn.Robot(links=6, link_mass_kg=1.0, link_length_m=0.12)
    >>> ground = sn.Ground(ct=0.1, cn=10.0)
    >>> gait = sn.Gait(alpha_rad=0.5236, beta_rad=1.3963, omega_rad_s=5.0)
    >>> soft = sn.steady_springs(robot, ground, gait, joint_stiffness_n_m=1e4, rtol=1e-3)
    >>> round(soft.speed_m_s, 2)
    0.29
    """

    speed_m_s: float
    power_w: float
    abs_power_w: float
    positive_power_w: float
    error_estimate: float
    power_error_w: float
    positive_power_error_w: float
    modelling_error: float
    cycles: int

    @property
    def abs_power_error_w(self) -> float:
        """Return the estimated error of abs_power_w = 2 positive_power_w - power_w, W."""
        return 2 * self.positive_power_error_w + self.power_error_w

    def in_words(self) -> str:
        """Return the speed as a builder asks for it."""
        speed = two_digits(self.speed_m_s)
        return f"About {speed} m/s with the implicit model's springs for joints."

    def rows(self) -> list[Row]:
        """Return speed, powers and errors."""
        return [
            Row("speed, joints with springs", "m/s", self.speed_m_s),
            Row("difference to the exact model", "%", 100 * self.modelling_error),
            Row("net power", "W", self.power_w),
            detail("power, each joint's absolute value", "W", self.abs_power_w),
            detail("power, no regeneration", "W", self.positive_power_w),
            detail("error of the speed, relative", "", self.error_estimate),
            detail("cycles until then", "", self.cycles),
        ]

    def to_dict(self) -> dict[str, Any]:
        """Return the figures as plain numbers, for JSON."""
        return asdict(self) | {"abs_power_error_w": self.abs_power_error_w}


def _cycles(
    robot: Robot,
    ground: Ground,
    gait: Gait,
    springs: tuple[float, float],
    rtol: float,
    max_steps: float = 1e6,
) -> Scene:
    """Return a scene whose step divides a cycle: stable, and short enough for rtol.

    max_steps: of a cycle, of which a state takes 20 at least, and so minutes.
    """
    period, method = gait.period_s, "rk4" if ground.smooth else "nonsmooth"
    scene = Scene(robot, ground, gait, "implicit", *springs, method=method, start="steady")
    # 1000 steps a cycle give powers to 1e-4 or closer, a tenth of them speeds to 1e-3.
    step_count = 1000 * min(max(1e-4 / rtol, 0.1), 1.0)
    step_count = max(step_count, 2 * period / largest_stable_step_s(scene))
    if step_count > max_steps:
        raise BadInput(
            f"joint_stiffness_n_m {springs[0]:g} and joint_damping_n_s_m {springs[1]:g} ask for "
            f"{step_count:.1g} time steps a cycle; at most {max_steps:.0e} are taken: make "
            "joints softer or less damped, or take the exact model, to which stiff joints come near"
        )
    steps = 2 * math.ceil(step_count / 2)
    return replace(scene, dt_s=period / steps, record_every=steps, record=("energy",))


def _settled(scene: Scene, rtol: float, max_cycles: int = 4096) -> tuple[Run, float, float, int]:
    """Follow the motion until its speed is the periodic state's to rtol.

    Returns the last run, what later cycles still change of the speed, m/s, how many times what the
    last cycle changed that is, and the cycles taken.
    """
    floor_m_s = speed_floor_m_s(scene.robot, scene.gait.omega_rad_s)
    cycles, count, change = 0, 8, math.inf
    while cycles < max_cycles:
        run = simulate(replace(scene, duration_s=count * scene.gait.period_s))
        cycles += count
        speeds = run.mean_speed_m_s(scene.gait.period_s)
        earlier, later = (float(np.ptp(part)) for part in np.split(speeds[-(count // 4 * 2) :], 2))
        shrunk = min(max(later / earlier, 0.1), 0.99) if earlier > 0 else 0.1
        change = 2 * later / (1 - shrunk)  # sum as geometric series go, twice for those that beat
        if change <= rtol * max(float(speeds[-1]), floor_m_s):
            return run, change, 1 / (1 - shrunk ** (1 / (count // 4))), cycles
        scene, count = replace(scene, start=run.state()), min(2 * count, 256)
    raise NotConverged(
        f"after {cycles} cycles the speed still varies by {change:.1g} m/s from cycle to cycle; "
        f"ask for a larger rtol than {rtol:g}, or more damping than "
        f"{scene.joint_damping_n_s_m:g} N s/m"
    )


def _powers_w(run: Run) -> Array:
    """Return net and positive power of every cycle of a run that recorded each, W, (cycles, 2)."""
    columns = [ENERGY_COLUMNS.index(name) for name in ("joint_work_j", "positive_work_j")]
    return np.diff(run.energy_j[:, columns], axis=0) / run.scene.gait.period_s


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

    The run starts from the exact periodic state on the slow manifold.

    Parameters
    ----------
    robot
        What crawls.
    ground
        Friction of what it crawls on.
    gait
        How its joints move.
    joint_stiffness_n_m
        Stiffness of the springs in the joints, N/m.
    joint_damping_n_s_m
        Damping in the joints, N s/m.
    rtol
        The run ends when the speed will change by less than this, relative; 1e-9 to 0.1.

    Returns
    -------
    SteadySprings
        Speeds, powers, their errors, and the modelling error.

    Raises
    ------
    BadInput
        For arguments out of range.
    NotConverged
        If the motion does not repeat within 4096 cycles.

    Examples
    --------
    >>> robot = sn.Robot(links=6, link_mass_kg=1.0, link_length_m=0.12)
    >>> ground = sn.Ground(ct=0.1, cn=10.0)
    >>> gait = sn.Gait(alpha_rad=0.5236, beta_rad=1.3963, omega_rad_s=5.0)
    >>> soft = sn.steady_springs(robot, ground, gait, joint_stiffness_n_m=1e4, rtol=1e-3)
    >>> round(soft.speed_m_s, 2)
    0.29
    """
    check_number("rtol", rtol, 1e-9, 0.1)
    exact = steady_gait(robot, ground, gait, powers=False)
    springs = joint_stiffness_n_m, joint_damping_n_s_m
    scene = _cycles(robot, ground, gait, springs, rtol)
    run, change_m_s, cycles_left, cycles = _settled(scene, rtol)
    floor = speed_floor_m_s(robot, gait.omega_rad_s)
    # After eight cycles with half the step its own periodic state is there.
    half = with_shorter_steps(replace(run.scene, duration_s=8 * gait.period_s), 2)
    fine = simulate(replace(half, start=run.state()))
    power_w, fine_power_w = _powers_w(run), _powers_w(fine)
    errors_w = np.abs(power_w[-1] - power_w[-2]) * (1 + cycles_left)
    errors_w += SAFETY * np.abs(fine_power_w[-1] - power_w[-1])
    (net_w, positive_w), (net_error_w, positive_error_w) = power_w[-1].tolist(), errors_w.tolist()
    speed, fine_speed = (float(r.mean_speed_m_s(gait.period_s)[-1]) for r in (run, fine))
    return SteadySprings(
        speed,
        net_w,
        2 * positive_w - net_w,
        positive_w,
        (change_m_s + 2 * abs(fine_speed - speed)) / max(speed, floor),
        net_error_w,
        positive_error_w,
        speed / max(exact.speed_m_s, floor) - 1,
        cycles,
    )
