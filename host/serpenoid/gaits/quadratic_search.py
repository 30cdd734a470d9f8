"""Least value of a function of two variables: quadratic models in a shrinking box, no gradients.

A model is fitted to nine points of a box; the least feasible point of the model is tried; the box
follows what is found, and shrinks where nothing is. Kinks and noise below the box's size do no
harm, and the last model tells how much lower the true least value may be.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
_STAR = np.array([[i, j] for i in (-1, 0, 1) for j in (-1, 0, 1) if i or j], dtype=float)
_MESH = np.stack(np.meshgrid(*[np.linspace(-1, 1, 41)] * 2), axis=-1).reshape(-1, 2)


@dataclass(frozen=True)
class Point:
    """Hold a point, the value there, the least room it leaves (below 0: not allowed), its data."""

    at: Array
    value: float
    room: float
    data: object = None

    @property
    def better(self) -> tuple[bool, float]:
        """Return what points are compared by: allowed first, then by value, or by room."""
        allowed = self.room >= -1e-6 and np.isfinite(self.value)
        return (not allowed, self.value if allowed else -self.room)


Evaluate = Callable[[Sequence[Array]], list[Point]]


def _fit(unit: Array, values: Array) -> Array | None:
    """Return the six coefficients of a quadratic through or near some points."""
    good = np.isfinite(values)
    if good.sum() < 6:
        return None
    return np.asarray(np.linalg.lstsq(_terms(unit[good]), values[good], rcond=None)[0], dtype=float)


def _terms(u: Array) -> Array:
    x, y = u[:, 0], u[:, 1]
    return np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=1)


def _lowest_of_model(star: list[Point], unit: Array) -> tuple[Array, float] | None:
    """Return where in the box the model is least and allowed, and its value there."""
    values = _fit(unit, np.array([p.value for p in star]))
    if values is None:
        return None
    model = _terms(_MESH) @ values
    rooms = np.array([min(p.room, 1e3) for p in star])
    if rooms.min() < 0.5:  # far from every limit there is none to model
        room = _fit(unit, rooms)
        if room is not None:
            model = np.where(_terms(_MESH) @ room >= 0, model, np.inf)
    k = int(np.argmin(model))
    return (_MESH[k], float(model[k])) if np.isfinite(model[k]) else None


def least(
    evaluate: Evaluate, start: Point, radius: float, smallest: float, low: Array, high: Array
) -> tuple[Point, float]:
    """Return the least allowed point near a start, and how much less there may still be.

    evaluate takes points and returns Points. radius: half the first box; smallest: of the last.
    low, high: bounds. What may be missing comes from the last model, whose box is `smallest`, or
    where it had none from what the last box gained.
    """
    best, gap = start, np.inf
    while radius >= smallest * (1 - 1e-9):
        at = np.clip(best.at + radius * _STAR, low, high)
        star = [best, *evaluate(list(at))]
        unit = np.array([(p.at - best.at) / radius for p in star])
        found = _lowest_of_model(star, unit)
        if found is not None and best.better[0] is False:
            gap = max(best.value - found[1], 0.0)
        if found is not None and np.any(found[0]):
            star += evaluate([np.clip(best.at + radius * found[0], low, high)])
        lowest = min(star, key=lambda p: p.better)
        gained = lowest.better < best.better
        step = np.abs(lowest.at - best.at).max()
        worth = best.value - lowest.value
        if found is None and np.isfinite(worth):  # beside an edge too few points have a value
            gap = max(worth, 0.0)
        best = lowest
        if not gained or step < 0.5 * radius or (not best.better[0] and worth < 1e-3 * radius**2):
            radius *= 0.4
    return best, gap
