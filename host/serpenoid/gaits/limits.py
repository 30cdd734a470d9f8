"""What a robot's joints and servos can do, and which of these limits a gait has reached."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace

import numpy as np

from ..base.checks import check_number
from ..base.errors import StepTooLarge
from ..model.gait import Gait
from ..model.ground import Ground
from ..model.robot import Robot
from ..simulation.scene import Scene
from ..simulation.simulate import simulate
from .shapes import STATES

LIMIT_NAMES = {
    "joint_angle_rad": "joint angle",
    "servo_speed_rad_s": "servo speed",
    "servo_torque_nm": "servo torque",
    "omega_high_rad_s": "highest rate",
    "omega_low_rad_s": "lowest rate",
}
LEAST_RATE_RAD_S = 1e-5  # of servos and gaits: a period of a week; slower states take minutes
_DEG = math.degrees(1.0)
_UNITS = {
    "joint_angle_rad": (_DEG, "deg"),
    "servo_speed_rad_s": (_DEG, "deg/s"),
    "servo_torque_nm": (1.0, "N m"),
    "omega_high_rad_s": (1.0, "rad/s"),
    "omega_low_rad_s": (1.0, "rad/s"),
}


@dataclass(frozen=True, slots=True)
class GaitLimits:
    """State what a gait may ask of the robot; infinite where there is no limit.

    Attributes
    ----------
    joint_angle_rad
        Limit of every joint's angle, either way, rad; by default 110 deg, where links touch.
    servo_speed_rad_s
        Limit of alpha omega, rad/s.
    servo_torque_nm
        Limit of every joint's torque at any time, N m.
    omega_low_rad_s, omega_high_rad_s
        Range of the gait's rate, rad/s.

    Raises
    ------
    BadInput
        For values out of range.

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

    def __post_init__(self) -> None:
        check_number("joint_angle_rad", self.joint_angle_rad, 0.0, math.pi, open_low=True)
        rates = dict.fromkeys(("servo_speed_rad_s", "omega_high_rad_s"), LEAST_RATE_RAD_S)
        for name, low in (rates | {"servo_torque_nm": 0.0}).items():
            most = getattr(self, name)
            if not (isinstance(most, float) and most == math.inf):
                check_number(name, most, low, open_low=low == 0.0)
        check_number("omega_low_rad_s", self.omega_low_rad_s, 0.0, self.omega_high_rad_s)

    def margins(self, gait: Gait, torque_nm: float = 0.0) -> dict[str, float]:
        """Return by how many e-folds a gait, or torque in N m, is below each limit."""
        bend, rate = abs(gait.offset_rad) + gait.alpha_rad, gait.omega_rad_s
        used = {
            "joint_angle_rad": (bend, self.joint_angle_rad),
            "servo_speed_rad_s": (gait.alpha_rad * rate, self.servo_speed_rad_s),
            "servo_torque_nm": (torque_nm, self.servo_torque_nm),
            "omega_high_rad_s": (rate, self.omega_high_rad_s),
            "omega_low_rad_s": (self.omega_low_rad_s, rate),
        }
        return {
            name: math.log(most / value) if value > 0 else math.inf
            for name, (value, most) in used.items()
            if most < math.inf and value < math.inf
        }

    def active(self, gait: Gait, torque_nm: float = 0.0) -> tuple[str, ...]:
        """Return the limits that a gait, or torque_nm in N m, has reached, in words."""
        margins = self.margins(gait, torque_nm)
        return tuple(LIMIT_NAMES[name] for name, left in margins.items() if left <= 2 * STATES)

    def in_words(self) -> str:
        """Return the limits there are, with their units; angles in degrees."""
        return ", ".join(
            f"{LIMIT_NAMES[f.name]} {getattr(self, f.name) * scale:.4g} {unit}"
            for f in fields(self)
            for scale, unit in (_UNITS[f.name],)
            if 0 < getattr(self, f.name) < math.inf
        )


def peak_torque_nm(robot: Robot, ground: Ground, gait: Gait, steps: int = 240) -> float:
    """Return the largest joint torque of a cycle of the periodic state, exact model, N m."""
    scene = Scene(
        robot,
        ground,
        gait,
        start="steady",
        method="rk4" if ground.smooth else "nonsmooth",
        dt_s=gait.period_s / steps,
        duration_s=gait.period_s,
        record=("joints",),
        record_every=1,
    )
    try:
        run = simulate(scene)
    except StepTooLarge:  # a gait so slow that friction holds it: steps are not what limits it
        run = simulate(replace(scene, method="nonsmooth"))
    return float(np.abs(run.joint_torque_nm).max())
