"""Periodic states on dry ground of gaits near one another, each begun where others expect it.

Half of a state's cost is to find it: from rest Newton's method follows four half cycles and more,
from a state expected by a linear fit to its neighbours one or two.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..model.core_model import core_model
from ..model.gait import Gait
from ..model.ground import Ground
from ..model.robot import Robot
from .grid import threads_to_use
from .steady import MAX_ELEMENTS

Array = NDArray[np.float64]
_NEAR = 0.01  # of a coordinate: knowledge nearer than this counts alike
_STIFF = 1e-3  # of the weights: slopes that the neighbours do not tell stay small


class NearState(NamedTuple):
    """Hold a gait's state: speed, m/s, powers, W, and the start over the rate (m, m, 1)."""

    gait: Gait
    speed_m_s: float
    power_w: float
    abs_power_w: float
    positive_power_w: float
    error_estimate: float
    start: Array


def solve_near(
    robot: Robot,
    ground: Ground,
    gaits: Sequence[Gait],
    starts: Sequence[Array] | None,
    rtol: float,
    powers: bool,
    rough: bool,
) -> list[NearState | None]:
    """Solve gaits from starts over their rates, (3,) each, or where None from the first one's.

    rough: one level, good to a thousandth or so. None in place of a state that was not found.
    """
    models = [core_model(robot, ground, gait) for gait in gaits]
    begin = (
        []
        if starts is None
        else [
            (gait.omega_rad_s * start).tolist() for gait, start in zip(gaits, starts, strict=True)
        ]
    )
    found = _core.neighbours(
        models[0],
        models,
        rtol,
        powers,
        MAX_ELEMENTS,
        min(threads_to_use(None), len(models)),
        rough=rough,
        starts=begin,
    )
    return [
        NearState(
            gait,
            s.speed,
            s.power,
            s.abs_power,
            s.positive_power,
            s.speed_error / max(s.speed, 1e-300),
            np.array(s.start) / gait.omega_rad_s,
        )
        if s.converged
        else None
        for gait, s in zip(gaits, found, strict=True)
    ]


class LocalFit:
    """Expect values at new places from those at known ones: linear fits, the near ones most."""

    def __init__(self, coordinates: int, values: int) -> None:
        self.at, self.values = np.empty((0, coordinates)), np.empty((0, values))

    def add(self, at: Array, values: Array) -> None:
        """Keep the values, (K, V), of K places, (K, C)."""
        self.at = np.concatenate([self.at, at])
        self.values = np.concatenate([self.values, values])

    def nearest(self, at: Array) -> float:
        """Return the distance to the nearest known place."""
        return float(np.abs(self.at - at).max(axis=1).min(initial=np.inf))

    def expect(self, at: Array) -> Array:
        """Return the values expected at some places, (K, C): a fit with weights round each."""
        apart = self.at[None] - at[:, None]
        weight = ((apart**2).sum(axis=2) + _NEAR**2) ** -2
        weight /= weight.sum(axis=1, keepdims=True)
        middle = np.einsum("km,kmc->kc", weight, apart)
        mean = weight @ self.values
        off, rest = apart - middle[:, None], self.values[None] - mean[:, None]
        square = np.einsum("km,kmc,kmd->kcd", weight, off, off)
        stiff = _STIFF * (np.trace(square, axis1=1, axis2=2) + _NEAR**2)
        square += stiff[:, None, None] * np.eye(at.shape[1])
        slopes = np.linalg.solve(square, np.einsum("km,kmc,kmv->kcv", weight, off, rest))
        return mean - np.einsum("kc,kcv->kv", middle, slopes)
