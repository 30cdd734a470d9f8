"""Speeds with servos over a grid of gaits: of the typical servo, and of some drawn ones."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from itertools import product

import numpy as np
from numpy.typing import NDArray

from ..model.drives import Servo, ServoKind
from ..model.errors import NotConverged
from ..model.gait import Gait
from ..model.ground import Ground
from ..model.robot import Robot
from .servo_steady import band, drawn_servo_speeds, servo_state
from .steady import Steady, steady_gait

Array = NDArray[np.float64]
_RTOL = 1e-3
_DRAWS = 64  # a gait: a grid has many


def servo_grid(
    robot: Robot,
    ground: Ground,
    axes: tuple[Array, Array, Array],
    servo: Servo | ServoKind,
    threads: int,
    progress: Callable[[int], None] | None = None,
) -> tuple[Array, Array, Array]:
    """Return speed of the typical servo, and ends of the band of drawn ones, m/s.

    axes: alpha_rad, beta_rad, omega_rad_s; the answers are indexed so. NaN where the motion with
    servos does not settle. An exact servo's band is its spread over the frames' phase.
    """
    size = tuple(len(axis) for axis in axes)
    servos = _servos(servo)

    def of(shape: tuple[float, float, float]) -> tuple[float, float, float]:
        try:
            ideal = steady_gait(robot, ground, Gait(*shape), rtol=_RTOL, powers=False)
        except NotConverged:
            return np.nan, np.nan, np.nan
        return _of_gait(ideal, servos)

    found = []
    with ThreadPoolExecutor(threads) as pool:
        for three in pool.map(of, product(*(axis.tolist() for axis in axes))):
            found.append(three)
            if progress is not None:
                progress(1)
    typical, low, high = np.array(found, dtype=float).T
    return typical.reshape(size), low.reshape(size), high.reshape(size)


def _of_gait(ideal: Steady, servos: list[Servo]) -> tuple[float, float, float]:
    """Return the first servo's speed, and the band of the others, or its own spread."""
    first, others = servo_state(ideal, servos[0]), servos[1:]
    typical = first.speed if first.converged else np.nan
    if not others:
        return typical, max(typical - first.spread, 0.0), typical + first.spread
    return typical, *band(drawn_servo_speeds([ideal] * len(others), others, threads=1))


def _servos(servo: Servo | ServoKind) -> list[Servo]:
    """Return the typical servo, and some drawn ones where it is in doubt."""
    if isinstance(servo, Servo):
        return [servo]
    return [servo.servo, *([] if servo.exact else servo.draws(_DRAWS))]
