"""Least power at one rate: where tables of shapes, each finer than the last, cross the speed.

A search over shapes takes the rate from the speed, and hardly ever meets a narrow range of rates.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import brentq

from ..model.errors import SerpenoidError
from ..model.gait import Gait
from .quadratic_search import Array, Point
from .shape_search import GaitShape, ShapeSearch, on_threads

_COARSE, _FINE = 40, 9  # shapes of a table, each way
_STARTS, _LEVELS, _FINER = 4, 6, 3.0  # crossings that are followed; tables; by what they shrink


class _Crossing(NamedTuple):
    """Hold where an edge of a table crosses the speed: cost, (ln alpha, ln beta), which of both."""

    watts: float
    at: Array
    axis: int


class RateSearch:
    """Cost of the shapes that give a speed, m/s, at one rate, rad/s."""

    def __init__(self, search: ShapeSearch, omega_rad_s: float, speed_m_s: float) -> None:
        self.search, self.omega_rad_s, self.speed_m_s = search, omega_rad_s, speed_m_s
        limits, (low, high) = search.limits, search.bounds()
        most = min(limits.joint_angle_rad, limits.servo_speed_rad_s / omega_rad_s)
        self.low = np.array([math.log(min(math.radians(1.0), most / 2)), low[1]])
        self.high = np.array([math.log(most), high[1]])

    def cheapest(self, rtol: float, coarse: float) -> tuple[Point, float] | None:
        """Return the cheapest allowed shape and how much less, in e-folds, there may still be.

        rtol: accuracy of the last state; coarse: of those on the way there.
        """
        step = (self.high - self.low) / (_COARSE - 1)
        middle = (self.low + self.high) / 2
        starts = self.crossings(middle, middle - self.low, _COARSE, coarse)
        followed = [self.follow(start, 2 * step, rtol, coarse) for start in _apart(starts, step)]
        allowed = [end for end in followed if end is not None and not end[0].better[0]]
        return min(allowed, key=lambda end: end[0].better, default=None)

    def follow(
        self, start: _Crossing, half: Array, rtol: float, coarse: float
    ) -> tuple[Point, float] | None:
        """Return the cheapest point round a crossing, and what the last table gained."""
        best, gain = start, math.inf
        for _ in range(_LEVELS):
            found = self.crossings(best.at, half, _FINE, coarse)
            if not found:
                break
            gain = abs(math.log(found[0].watts / best.watts)) if best.watts > 0 else math.inf
            best, half = found[0], half / _FINER
        point = self.solved(best, 2 * half, rtol)
        return None if point is None else (point, gain)

    def crossings(self, at: Array, half: Array, count: int, rtol: float) -> list[_Crossing]:
        """Return where the edges of a table round a shape cross the speed, the cheapest first."""
        box = zip(np.maximum(at - half, self.low), np.minimum(at + half, self.high), strict=True)
        axes = [np.linspace(low, high, count) for low, high in box]
        mesh = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
        states = on_threads(lambda shape: self.state(shape, rtol), mesh.reshape(-1, 2))
        told = [
            (s.speed_m_s, getattr(s, f"{self.search.cost}_w")) if s else (math.nan,) * 2
            for s in states
        ]
        miss, watts = np.moveaxis(np.reshape(told, (count, count, 2)), -1, 0)
        miss = miss - self.speed_m_s
        found = [c for axis in (0, 1) for c in _on_edges(mesh, miss, watts, axis)]
        return sorted(found, key=lambda crossing: crossing.watts)

    def state(self, shape: Array, rtol: float) -> Any | None:
        """Return the state of (ln alpha, ln beta), or None where there is none."""
        alpha, beta = np.exp(np.minimum(shape, self.high))
        try:
            return self.search.solve(Gait(float(alpha), float(beta), self.omega_rad_s), rtol)
        except SerpenoidError:
            return None

    def solved(self, crossing: _Crossing, half: Array, rtol: float) -> Point | None:
        """Return the point of a crossing, with the speed to rtol."""
        along, states = np.eye(2)[crossing.axis], {}

        def miss(part: float) -> float:
            states[part] = self.state(crossing.at + part * along, rtol)
            return states[part].speed_m_s / self.speed_m_s - 1 if states[part] else math.nan

        width = float(half[crossing.axis])
        try:
            root = brentq(miss, -width, width, xtol=1e-15)
        except ValueError:  # no crossing any more, or no state
            return None
        found: Any = (
            states[root] if root in states else self.state(crossing.at + root * along, rtol)
        )
        value = math.log(max(getattr(found, f"{self.search.cost}_w"), 1e-300))
        room = min(self.search.room(found.gait).values(), default=math.inf)
        shape = GaitShape.of(found.gait.alpha_rad, found.gait.beta_rad)
        return Point(np.array(shape), value, room, found)


def _on_edges(mesh: Array, miss: Array, watts: Array, axis: int) -> list[_Crossing]:
    """Return where the edges along an axis cross zero, by straight lines."""
    one, other = (slice(None, -1), slice(1, None))
    first, second = ((one, slice(None)), (other, slice(None))) if axis == 0 else (
        (slice(None), one), (slice(None), other)
    )  # fmt: skip
    crossed = miss[first] * miss[second] <= 0
    part = (miss[first] / (miss[first] - miss[second] + 1e-300))[crossed]
    cost = watts[first][crossed] * (1 - part) + watts[second][crossed] * part
    at = mesh[first][crossed] * (1 - part)[:, None] + mesh[second][crossed] * part[:, None]
    return [_Crossing(float(c), a, axis) for c, a in zip(cost, at, strict=True)]


def _apart(crossings: list[_Crossing], step: Array) -> list[_Crossing]:
    """Return the cheapest of some sorted crossings that are some steps from each other."""
    kept: list[_Crossing] = []
    for one in crossings:
        if all(np.abs((one.at - other.at) / step).max() > 4 for other in kept):
            kept.append(one)
    return kept[:_STARTS]
