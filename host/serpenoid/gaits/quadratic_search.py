"""Minimize a function of two variables by quadratic models in a shrinking box, without gradients.

A model is fitted to nine points of a box, and its lowest allowed point is tried, at a limit on the
limit's own curve. The box follows a lower point, and shrinks where there is none. Kinks and noise
smaller than the box do no harm. The last model says how much lower the true minimum may be.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
_SHRINK = 0.4  # of the box, where it finds nothing lower
_INTO, _LOWER = 0.1, 1e-3  # of coordinates, of the value: so near to another search's end
_HOPELESS = 0.03  # of the value: so far above it
_WORTHWHILE = 1e-3  # of radius^2, in e-folds of the value: a smaller gain shrinks the box
_ALLOWED = -1e-8  # margin: rounding beyond a limit
_FAR = 0.5  # margin, e-folds: a box so far from every limit needs no model of it
_STAR = np.array([[i, j] for i in (-1, 0, 1) for j in (-1, 0, 1) if i or j], dtype=float)
_MESH = np.stack(np.meshgrid(*[np.linspace(-1, 1, 41)] * 2), axis=-1).reshape(-1, 2)
_LINE = np.linspace(-1, 1, 401)
_SWAPPED = [0, 2, 1, 5, 4, 3]  # coefficients for (y, x) in place of (x, y)


@dataclass(frozen=True)
class Point:
    """Hold a point, its value, its least margin to a limit (below 0: not allowed), and its data."""

    at: Array
    value: float
    margin: float
    data: object = None

    @property
    def better(self) -> tuple[bool, float]:
        """Return the key that orders points: allowed ones first, by value; others by margin."""
        allowed = self.margin >= _ALLOWED and np.isfinite(self.value)
        return (not allowed, self.value if allowed else -self.margin)


class Valley(NamedTuple):
    """Hold a valley's lowest point, and how much less there may be, e-folds.

    tangent: how its swing, lag and ln rate change with ln speed, where that is known.
    """

    end: Point
    gap: float
    tangent: Array | None = None


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


def _curve(margin: Array) -> Array:
    """Return points of the box where a quadratic is 0, (K, 2): one or two on each line of it."""
    c = margin[0] + margin[1] * _LINE + margin[3] * _LINE**2
    b, a = margin[2] + margin[4] * _LINE, margin[5]
    with np.errstate(invalid="ignore", divide="ignore"):
        q = -0.5 * (b + np.copysign(np.sqrt(b * b - 4 * a * c), b))
        roots = np.concatenate([np.stack([_LINE, y], axis=1) for y in (q / a, c / q)])
    return roots[np.abs(roots[:, 1]) <= 1]


def _lowest_of_model(
    star: list[Point], unit: Array, room: float = 0.0
) -> tuple[Array, float] | None:
    """Return the lowest point of the model in the box with such a margin, and its value there."""
    values = _fit(unit, np.array([p.value for p in star]))
    if values is None:
        return None
    at, allowed = _MESH, np.ones(len(_MESH), bool)
    margins = np.array([min(p.margin, 1e3) for p in star])
    margin = _fit(unit, margins - room) if margins.min() < _FAR else None
    if margin is not None:
        edges = _curve(margin), _curve(margin[_SWAPPED])[:, ::-1]
        allowed = np.append(_terms(_MESH) @ margin >= 0, np.ones(sum(map(len, edges)), bool))
        at = np.concatenate([_MESH, *edges])
    model = np.where(allowed, _terms(at) @ values, np.inf)
    k = int(np.argmin(model))
    return (at[k], float(model[k])) if np.isfinite(model[k]) else None


def _hopeless(point: Point, beat: Point | None) -> bool:
    """Tell whether a search leads to the end of another, or far above it."""
    if beat is None or point.better[0]:
        return False
    above = point.value - beat.value
    into = np.abs(point.at - beat.at).max() < _INTO and above > -_LOWER
    return bool(into or above > _HOPELESS)


def minimize(
    evaluate: Evaluate,
    start: Point,
    radius: float,
    smallest: float,
    low: Array,
    high: Array,
    beat: Point | None = None,
) -> Valley:
    """Return the lowest allowed point near a start, and how much lower the minimum may be.

    evaluate: takes points and returns Points. radius, smallest: half of the first and of the last
    box. low, high: bounds. beat: the end of another search, if any; this one ends where it
    leads there, or stays far above. The gap comes from the last model, or where there was none from
    what the last box gained.
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
            short = -star[-1].margin
            if short > 0 and np.isfinite(star[-1].value):  # the limit's curve is not the model's
                inside = _lowest_of_model(star[:-1], unit, short)
                if inside is not None and np.any(inside[0]):
                    star += evaluate([np.clip(best.at + radius * inside[0], low, high)])
        lowest = min(star, key=lambda p: p.better)
        gained = lowest.better < best.better
        step = np.abs(lowest.at - best.at).max()
        worth = best.value - lowest.value
        if found is None and np.isfinite(worth):  # beside an edge too few points have a value
            gap = max(worth, 0.0)
        best = lowest
        if _hopeless(best, beat):
            break
        if (
            not gained
            or step < 0.5 * radius
            or (not best.better[0] and worth < _WORTHWHILE * radius**2)
        ):
            radius *= _SHRINK
    return Valley(best, gap)
