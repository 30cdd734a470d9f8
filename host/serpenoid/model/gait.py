"""The gait of Eq. 57, one sine wave that runs along the joints, and how they move under it."""

from __future__ import annotations

import math
import warnings
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..base.checks import POSITIVE, Limits, check_fields, check_number
from ..base.errors import BadInput
from ..base.vectors import Array, number_array

_BY_JOINT = {"joint_gain": Limits(0.0, 2.0), "joint_shift_rad": Limits(-math.pi, math.pi)}


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
    >>> gait = sn.Gait(alpha_rad=1.22, beta_rad=1.31, omega_rad_s=4.0)
    >>> round(gait.period_s, 4)
    1.5708
    """

    alpha_rad: float
    beta_rad: float
    omega_rad_s: float
    offset_rad: float = 0.0
    joint_gain: tuple[float, ...] = ()
    joint_shift_rad: tuple[float, ...] = ()

    @classmethod
    def degrees(
        cls,
        alpha_deg: float,
        beta_deg: float,
        *,
        hertz: float | None = None,
        omega_rad_s: float | None = None,
        offset_deg: float = 0.0,
    ) -> Gait:
        """Return a gait of angles in degrees and a frequency in hertz, or a rate.

        Parameters
        ----------
        alpha_deg, beta_deg
            Amplitude and phase lag from joint to joint, degrees.
        hertz
            Cycles a second, above 0.
        omega_rad_s
            Angular rate, above 0, rad/s, in place of the frequency.
        offset_deg
            Constant bend of every joint, degrees.

        Returns
        -------
        Gait
            The same gait in radians.

        Raises
        ------
        BadInput
            For values out of range, and unless one of frequency and rate is given.

        Examples
        --------
        >>> gait = sn.Gait.degrees(70, 75, hertz=0.5)
        >>> gait.period_s, round(gait.alpha_rad, 4)
        (2.0, 1.2217)
        """
        alpha_rad = math.radians(check_number("alpha_deg", alpha_deg, 0.0, 180.0))
        beta_rad = math.radians(check_number("beta_deg", beta_deg, -360.0, 360.0))
        offset_rad = math.radians(check_number("offset_deg", offset_deg, -180.0, 180.0))
        if (hertz is None) == (omega_rad_s is None):
            raise BadInput("a gait has a frequency or a rate; give one of hertz, omega_rad_s")
        if omega_rad_s is None:
            omega_rad_s = math.tau * check_number("hertz", hertz, *POSITIVE)
        if 0.0 < alpha_deg < math.pi and 0.0 < abs(beta_deg) < math.tau:
            warnings.warn(
                f"alpha is {alpha_deg:g} degrees and beta {beta_deg:g}; if radians were meant, "
                f"they are {math.degrees(alpha_deg):.3g} and {math.degrees(beta_deg):.3g} degrees",
                stacklevel=2,
            )
        return cls(alpha_rad, beta_rad, omega_rad_s, offset_rad)

    def __post_init__(self) -> None:
        ranges = {
            "alpha_rad": Limits(0.0, math.pi),
            "beta_rad": Limits(-math.tau, math.tau),
            "omega_rad_s": POSITIVE,
            "offset_rad": Limits(-math.pi, math.pi),
        }
        check_fields(self, ranges)
        for name, limits in _BY_JOINT.items():
            values = number_array(name, getattr(self, name)).ravel().tolist()
            object.__setattr__(
                self, name, tuple(check_number(name, value, *limits) for value in values)
            )

    @property
    def period_s(self) -> float:
        """Return 2 pi / omega, s."""
        return math.tau / self.omega_rad_s

    def joint_factors(self, joints: int) -> tuple[Array, Array]:
        """Return gain and phase shift of each joint, (joints,). Raises BadInput: a wrong number."""
        for name in _BY_JOINT:
            count = len(getattr(self, name))
            if count not in (0, joints):
                raise BadInput(f"{name} has {count} values; the robot has {joints} joints")
        gain = np.array(self.joint_gain) if self.joint_gain else np.ones(joints)
        shift = np.array(self.joint_shift_rad) if self.joint_shift_rad else np.zeros(joints)
        return gain, shift


def gait_name(gait: Gait) -> str:
    """Return amplitude, lag, frequency and the bend of a gait that steers: '70°/75°, 0.5 Hz'."""
    alpha, beta, offset = map(math.degrees, (gait.alpha_rad, gait.beta_rad, gait.offset_rad))
    bend = f", bend {offset:.3g}°" if offset else ""
    return f"{alpha:.3g}°/{beta:.3g}°, {gait.omega_rad_s / math.tau:.3g} Hz{bend}"


def joint_motion(gait: Gait, joints: int, t_s: ArrayLike = 0.0) -> tuple[Array, Array, Array]:
    """Return the joints' angles (rad), rates (rad/s) and second derivatives (rad/s^2), by Eq. 57.

    Each joint has its own gain and shift where the gait has them. t_s: a time, or times of any
    shape; the joints are the last axis of what comes back.
    """
    rate, (gain, shift) = gait.omega_rad_s, gait.joint_factors(joints)
    lag = gait.beta_rad * np.arange(joints) + shift
    phase = np.asarray(rate * np.asarray(t_s))[..., None] + lag
    swing = gain * gait.alpha_rad * np.sin(phase)
    with np.errstate(over="ignore"):  # an infinite acceleration
        acceleration = -rate * (rate * swing)
    speed = rate * gain * gait.alpha_rad * np.cos(phase)
    return gait.offset_rad + swing, speed, acceleration
