"""The gait of Eq. 57: one sine wave that runs along the joints."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .checks import check_number
from .errors import BadInput

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Gait:
    """Describe the joint angles phi_i(t) = offset + alpha sin(omega t + (i - 1) beta), Eq. 57.

    phi_i = theta_{i+1} - theta_i is the angle of joint i, i = 1..n-1 counted from the tail.

    Attributes
    ----------
    alpha_rad
        Amplitude, 0 to pi, rad.
    beta_rad
        Phase lag from joint to joint, rad.
    omega_rad_s
        Angular rate, above 0, rad/s.
    offset_rad
        Constant bend of every joint, rad; it steers.
    joint_gain
        What real servos leave of each joint's amplitude: a factor 0 to 2 a joint, or () for 1.
    joint_shift_rad
        What real servos add to each joint's phase, rad, one a joint, or () for 0.

    Raises
    ------
    BadInput
        For values out of range.

    Examples
    --------
    >>> gait = sn.Gait(alpha_rad=1.22, beta_rad=1.31, omega_rad_s=5.0)
    >>> round(gait.period_s, 4)
    1.2566
    """

    alpha_rad: float
    beta_rad: float
    omega_rad_s: float
    offset_rad: float = 0.0
    joint_gain: tuple[float, ...] = ()
    joint_shift_rad: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        checked = {
            "alpha_rad": check_number("alpha_rad", self.alpha_rad, 0.0, math.pi),
            "beta_rad": check_number("beta_rad", self.beta_rad, -2 * math.pi, 2 * math.pi),
            "omega_rad_s": check_number("omega_rad_s", self.omega_rad_s, 0.0, open_low=True),
            "offset_rad": check_number("offset_rad", self.offset_rad, -math.pi, math.pi),
        }
        for name, value in checked.items():
            object.__setattr__(self, name, value)
        for name, low, high in (("joint_gain", 0.0, 2.0), ("joint_shift_rad", -math.pi, math.pi)):
            given = getattr(self, name)
            if not isinstance(given, Iterable):
                raise BadInput(f"{name} is {given!r}; it must be one value a joint, or () for none")
            each = tuple(check_number(name, value, low, high) for value in given)
            object.__setattr__(self, name, each)

    def __repr__(self) -> str:
        """Return what was given; joints of their own only where there are any."""
        names = ["alpha_rad", "beta_rad", "omega_rad_s", "offset_rad"]
        names += [name for name in ("joint_gain", "joint_shift_rad") if getattr(self, name)]
        return f"Gait({', '.join(f'{name}={getattr(self, name)!r}' for name in names)})"

    @property
    def period_s(self) -> float:
        """Return 2 pi / omega, s."""
        return 2 * math.pi / self.omega_rad_s

    def joint_factors(self, joints: int) -> tuple[Array, Array]:
        """Return gain and phase shift of each joint, (joints,). Raises BadInput: a wrong number."""
        for name in ("joint_gain", "joint_shift_rad"):
            count = len(getattr(self, name))
            if count not in (0, joints):
                raise BadInput(f"{name} has {count} values; the robot has {joints} joints")
        gain = np.array(self.joint_gain) if self.joint_gain else np.ones(joints)
        shift = np.array(self.joint_shift_rad) if self.joint_shift_rad else np.zeros(joints)
        return gain, shift


def gait_words(gait: Gait) -> str:
    """Return amplitude, lag and rate, and the bend of a gait that steers."""
    alpha, beta, offset = map(math.degrees, (gait.alpha_rad, gait.beta_rad, gait.offset_rad))
    bend = f", bend {offset:.5g}°" if offset else ""
    return f"{alpha:.5g}°/{beta:.5g}°, {gait.omega_rad_s:.5g} rad/s{bend}"
