"""Limits of a robot's joints and servos, and how near a gait is to them."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from ..base.checks import check_number
from ..base.errors import StepTooLarge
from ..base.rows import Result, Row, detail
from ..model.core_model import check_parts
from ..model.gait import Gait
from ..model.ground import Ground
from ..model.robot import Robot
from ..periodic.steady import Steady, speed_floor_m_s, state_near
from ..simulation.scene import Scene
from ..simulation.simulate import simulate

# Attribute of GaitLimits -> its name and unit in messages; "" if messages leave it out.
LIMITS = {
    "joint_angle_rad": ("joint angle", "deg"),
    "servo_speed_rad_s": ("servo speed", "deg/s"),
    "servo_torque_nm": ("servo torque", "N m"),
    "omega_high_rad_s": ("highest rate", "rad/s"),
    "omega_low_rad_s": ("lowest rate", "rad/s"),
    "kept_speed_share": ("speed kept", ""),
}
REACHED = 2e-3  # Relative distance from a limit below which it counts as reached.
LESS_AMPLITUDE, LESS_FRICTION = 0.10, 0.20  # Relative reductions by which losses are defined.


@dataclass(frozen=True, slots=True)
class GaitLimits:
    """The limits that a gait must keep; infinite where there is none.

    Attributes
    ----------
    joint_angle_rad
        Limit of every joint's angle to either side, rad; by default 110 deg, where links touch.
    servo_speed_rad_s
        Limit of alpha omega, rad/s.
    servo_torque_nm
        Limit of every joint's torque at any time, N m.
    omega_low_rad_s
        Lowest rate of the gait, rad/s.
    omega_high_rad_s
        Highest rate of the gait, rad/s.
    kept_speed_share
        Smallest share of the speed that must remain with 10 % less amplitude, and with 20 % less
        friction across the links, 0 to 0.99. If no gait keeps it, the search returns the one that
        keeps most.

    Raises
    ------
    BadInput
        If a value is out of range.

    Examples
    --------
    >>> robot = sn.Robot(links=6, link_mass_kg=1.0, link_length_m=0.12)
    >>> ground = sn.Ground(ct=0.1, cn=10.0)
    >>> limits = sn.GaitLimits(joint_angle_rad=0.5)
    >>> best = sn.least_power_gait(robot, ground, speed_m_s=0.1, limits=limits)
    >>> round(best.gait.alpha_rad, 3), best.active
    (0.5, ('joint angle',))
    """

    joint_angle_rad: float = math.radians(110.0)
    servo_speed_rad_s: float = math.inf
    servo_torque_nm: float = math.inf
    omega_low_rad_s: float = 0.0
    omega_high_rad_s: float = math.inf
    kept_speed_share: float = 0.0

    def __post_init__(self) -> None:
        check_number("joint_angle_rad", self.joint_angle_rad, 0.0, math.pi, open_low=True)
        for name, low in (
            ("servo_torque_nm", 0.0),
            ("servo_speed_rad_s", 1e-5),  # A period of a week; slower gaits take minutes to solve.
            ("omega_high_rad_s", 1e-5),
        ):
            limit = getattr(self, name)
            if not (isinstance(limit, float) and limit == math.inf):
                check_number(name, limit, low, open_low=low == 0.0)
        check_number("kept_speed_share", self.kept_speed_share, 0.0, 0.99)
        check_number("omega_low_rad_s", self.omega_low_rad_s, 0.0, self.omega_high_rad_s)

    def margins(self, gait: Gait, torque_nm: float = 0.0) -> dict[str, float]:
        """Return log(limit / value) of a gait and its peak torque, N m, for each finite limit."""
        bend, rate = abs(gait.offset_rad) + gait.alpha_rad, gait.omega_rad_s
        used = {
            "joint_angle_rad": (bend, self.joint_angle_rad),
            "servo_speed_rad_s": (gait.alpha_rad * rate, self.servo_speed_rad_s),
            "servo_torque_nm": (torque_nm, self.servo_torque_nm),
            "omega_high_rad_s": (rate, self.omega_high_rad_s),
            "omega_low_rad_s": (self.omega_low_rad_s, rate),
        }
        return {
            name: math.log(limit / value) if value > 0 else math.inf
            for name, (value, limit) in used.items()
            if limit < math.inf and value < math.inf
        }

    def active(
        self, gait: Gait, torque_nm: float = 0.0, speed_share: float = 1.0
    ) -> tuple[str, ...]:
        """Return the names of the limits that a gait has reached.

        torque_nm: its peak torque, N m. speed_share: share of the speed that it keeps, defined as
        for kept_speed_share.
        """
        margins = self.margins(gait, torque_nm)
        names = [name for name, margin in margins.items() if margin <= REACHED]
        if speed_share <= self.kept_speed_share * (1 + REACHED):
            names.append("kept_speed_share")
        return tuple(LIMITS[name][0] for name in names)

    def in_words(self) -> str:
        """Return the finite limits in words, with their units, angles in degrees."""
        parts = []
        for name, (words, unit) in LIMITS.items():
            limit = getattr(self, name)
            if unit and 0 < limit < math.inf:
                shown = math.degrees(limit) if "deg" in unit else limit
                parts.append(f"{words} {shown:.4g} {unit}")
        return ", ".join(parts)


def peak_torque_nm(robot: Robot, ground: Ground, gait: Gait) -> float:
    """Return the largest joint torque of a cycle of the periodic state, exact model, N m."""
    scene = Scene(
        robot,
        ground,
        gait,
        start="steady",
        method="rk4" if ground.smooth else "nonsmooth",
        dt_s=gait.period_s / 240,
        duration_s=gait.period_s,
        record=("joints",),
        record_every=1,
    )
    try:
        run = simulate(scene)
    except StepTooLarge:  # A gait so slow that friction nearly holds it is stiff.
        run = simulate(replace(scene, method="nonsmooth"))
    return float(np.abs(run.joint_torque_nm).max())


@dataclass(frozen=True, slots=True)
class SpeedLosses(Result):
    """The shares of its speed that a gait loses with less amplitude or friction; NaN at rest.

    Attributes
    ----------
    amplitude
        Share of the speed that is lost with 10 % less amplitude of the joints.
    friction
        Share that is lost with 20 % less friction across the links (cn and fn0).

    Examples
    --------
    >>> robot = sn.Robot(links=6, link_mass_kg=0.0756, link_length_m=0.076)
    >>> ground = sn.Ground.whole_body(links=6, ct=0.084, cn=1.2, ft0=0.14, fn0=0.27)
    >>> losses = sn.speed_losses(robot, ground, sn.Gait.degrees(70, 75, hertz=0.6))
    >>> round(losses.friction, 2)
    0.38
    """

    amplitude: float
    friction: float

    @property
    def worst(self) -> float:
        """Return the larger share; NaN for a gait that does not travel."""
        return max(self.amplitude, self.friction)

    def in_words(self) -> str:
        """Return the larger loss with its cause, e.g. '12 % of its speed with ...'."""
        cause = f"{100 * LESS_AMPLITUDE:.0f} % less amplitude"
        if self.friction > self.amplitude:
            cause = f"{100 * LESS_FRICTION:.0f} % less friction across"
        return f"{100 * max(self.worst, 0.0):.0f} % of its speed with {cause}"

    @property
    def warning(self) -> str:
        """Return a warning if the gait loses more than a quarter of its speed, else ""."""
        if math.isnan(self.worst):
            return "this gait does not travel: there is no speed to lose"
        sharp_drop = 0.25
        if self.worst <= sharp_drop:
            return ""
        return f"this gait stands at a sharp drop of speed: it loses {self.in_words()}"

    def rows(self) -> list[Row]:
        """Return both losses, %; none for a gait at rest."""
        parts = {
            "speed lost with 10 % less amplitude": self.amplitude,
            "speed lost with 20 % less friction across": self.friction,
        }
        return [detail(n, "%", 100 * part) for n, part in parts.items() if not math.isnan(part)]

    def to_dict(self) -> dict[str, Any]:
        """Return both shares by name, for JSON."""
        return asdict(self)


def speed_losses(robot: Robot, ground: Ground, gait: Gait) -> SpeedLosses:
    """Return the shares of its speed that a gait loses with less amplitude and less friction.

    Parameters
    ----------
    robot
        The robot.
    ground
        Friction of the ground on a link.
    gait
        Motion of the joints.

    Returns
    -------
    SpeedLosses
        The losses with 10 % less amplitude, and with 20 % less friction across the links.

    Raises
    ------
    BadInput
        If an argument is of the wrong type.

    Examples
    --------
    >>> robot = sn.Robot(links=6, link_mass_kg=0.0756, link_length_m=0.076)
    >>> ground = sn.Ground.whole_body(links=6, ct=0.084, cn=1.2, ft0=0.14, fn0=0.27)
    >>> losses = sn.speed_losses(robot, ground, sn.Gait.degrees(80, 75, hertz=0.6))
    >>> losses.worst < 0.25, losses.warning
    (True, '')
    """
    check_parts(robot, ground, gait)
    amplitude, friction = speed_shares(robot, ground, gait)
    return SpeedLosses(1 - amplitude, 1 - friction)


def speed_shares(
    robot: Robot, ground: Ground, gait: Gait, *, rtol: float = 1e-5, state: Steady | None = None
) -> tuple[float, float]:
    """Return the shares of the speed kept with 10 % less amplitude, and 20 % less friction across.

    They are NaN for a gait that does not travel. state: its periodic state, if it is known.
    """
    weak = replace(gait, alpha_rad=(1 - LESS_AMPLITUDE) * gait.alpha_rad)
    share = 1 - LESS_FRICTION
    slippery = replace(ground, cn=share * ground.cn, fn0=share * ground.fn0)
    full = state or state_near(robot, ground, gait, rtol=rtol, powers=False, start=None)
    start = None if ground.smooth else full
    speeds = [
        state_near(robot, *changed, rtol=rtol, powers=False, start=start).speed_m_s
        for changed in ((ground, weak), (slippery, gait))
    ]
    if full.speed_m_s <= speed_floor_m_s(robot, gait.omega_rad_s):
        return math.nan, math.nan
    return speeds[0] / full.speed_m_s, speeds[1] / full.speed_m_s
