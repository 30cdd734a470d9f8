"""Eq. 57: angle, rate and second derivative of every joint under a gait, at one time or at many."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .gait import Gait

Array = NDArray[np.float64]


class JointMotion(NamedTuple):
    """Hold phi_i (rad), its rate (rad/s) and second derivative (rad/s^2), (..., joints) each."""

    angle_rad: Array
    rate_rad_s: Array
    acceleration_rad_s2: Array


def joint_motion(gait: Gait, joints: int, t_s: ArrayLike = 0.0) -> JointMotion:
    """Return how the joints move, from the tail: phi_i = offset + alpha sin(omega t + (i-1) beta).

    Each joint has its own gain and shift where the gait has them. t_s: a time, or times of any
    shape; the joints are the last axis of what comes back.
    """
    rate, (gain, shift) = gait.omega_rad_s, gait.joint_factors(joints)
    lag = gait.beta_rad * np.arange(joints) + shift
    phase = np.asarray(rate * np.asarray(t_s))[..., None] + lag
    swing = gain * gait.alpha_rad * np.sin(phase)
    with np.errstate(over="ignore"):  # of a rate beyond any robot's: an infinite acceleration
        acceleration = -rate * (rate * swing)
    speed = rate * gain * gait.alpha_rad * np.cos(phase)
    return JointMotion(gait.offset_rad + swing, speed, acceleration)
