"""Speed of one gait over frictions, solved once at many points and interpolated, for studies."""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from numpy.typing import NDArray
from serpenoid import Gait, Ground, Robot
from serpenoid.prediction.speeds import speed

Array = NDArray[np.float64]
# Of the 2005 robot's ct, cn, ft0, fn0: as far as a session with a 7.5 degree bend errs.
LOW, HIGH = np.array([0.05, 0.02, 0.11, 0.12]), np.array([0.12, 3.6, 0.17, 0.45])


class SpeedTable:
    """Interpolate speed in m/s between Sobol points; frictions outside count as the box's edge.

    box: lowest and highest ct, cn, ft0, fn0, whole snake; kernel: of the interpolation, smooth
    where the box is small.
    """

    def __init__(
        self,
        robot: Robot,
        gait: Gait,
        points: int = 512,
        box: tuple[Array, Array] = (LOW, HIGH),
        kernel: str = "linear",
        neighbours: int = 40,
    ):
        from scipy.interpolate import RBFInterpolator
        from scipy.stats import qmc

        self._box = box
        low, high = box
        unit = qmc.Sobol(4, seed=7).random(points)  # pyright: ignore[reportCallIssue]
        grounds = [Ground.whole_body(robot.links, *x) for x in (low + unit * (high - low)).tolist()]
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            speeds = list(pool.map(lambda g: speed(robot, g, gait), grounds))
        self._of = RBFInterpolator(unit, np.array(speeds), neighbors=neighbours, kernel=kernel)

    def __call__(self, frictions: Array) -> Array:
        """Return the speeds of (count, 4) frictions of the whole snake."""
        low, high = self._box
        return self._of(np.clip((frictions - low) / (high - low), 0.0, 1.0))
