"""Least power at one rate: where tables of shapes, each finer than the last, cross the speed.

A search over shapes solves for the rate that gives the speed. In a narrow range of rates it almost
never finds an allowed one.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import brentq

from ..model.errors import SerpenoidError
from ..model.gait import Gait
from .gait_table import GaitTable
from .quadratic_search import Array, Point
from .shape_search import GaitShape, ShapeSearch

_COARSE, _FINE = 40, 9  # shapes of the first table and of the finer ones, each way
_STARTS, _APART = 4, 4  # crossings that are followed, and their distance in steps of the table
_LEVELS, _FINER = 6, 3.0  # finer tables, each this many times smaller
_LEAST_ALPHA_RAD = math.radians(1.0)


class _Crossing(NamedTuple):
    """Hold where an edge of a table crosses the speed: cost, (ln alpha, ln beta), its axis."""

    watts: float
    at: Array
    axis: int


class FixedRateSearch:
    """Cost of the shapes that give a speed, m/s, at one rate, rad/s."""

    def __init__(self, search: ShapeSearch, omega_rad_s: float, speed_m_s: float) -> None:
        self.search, self.omega_rad_s, self.speed_m_s = search, omega_rad_s, speed_m_s
        limits, (low, high) = search.limits, search.bounds()
        most = min(limits.joint_angle_rad, limits.servo_speed_rad_s / omega_rad_s)
        self.low = np.array([math.log(min(_LEAST_ALPHA_RAD, most / 2)), low[1]])
        self.high = np.array([math.log(most), high[1]])

    def minimize(self, rtol: float, coarse: float) -> tuple[Point, float] | None:
        """Return the cheapest allowed shape and how much less, in e-folds, there may still be.

        rtol: accuracy of the last state; coarse: of the tables.
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
        mesh = np.stack(
            np.meshgrid(*(np.linspace(low, high, count) for low, high in box), indexing="ij"), -1
        )

        def column(alpha: Array, beta: float, rates: Array) -> tuple[Array, Array]:
            found = [self.state(float(a), beta, rtol) for a in alpha]
            told = [(s.speed_m_s, self.search.watts(s)) if s else (math.nan,) * 2 for s in found]
            speed, cost = np.array(told).T
            return speed[:, None], cost[:, None]

        search = self.search
        table = GaitTable(
            search.robot,
            search.ground,
            search.cost,
            search.limits,
            np.exp(mesh[:, :, 0]),
            np.exp(mesh[:, :, 1]),
            rtol,
            column,
        )
        table.add_rates(np.array([self.omega_rad_s]))
        miss, watts = table.speed_m_s[:, :, 0] - self.speed_m_s, table.cost_w[:, :, 0]
        found = [c for axis in (0, 1) for c in _on_edges(mesh, miss, watts, axis)]
        return sorted(found, key=lambda crossing: crossing.watts)

    def state(self, alpha_rad: float, beta_rad: float, rtol: float) -> Any | None:
        """Return the state of a shape, or None where there is none."""
        beta_rad = min(beta_rad, math.pi)
        try:
            return self.search.solve(Gait(alpha_rad, beta_rad, self.omega_rad_s), rtol)
        except SerpenoidError:
            return None

    def solved(self, crossing: _Crossing, half: Array, rtol: float) -> Point | None:
        """Return the point of a crossing, with the speed to rtol."""
        along, states = np.eye(2)[crossing.axis], {}

        def miss(part: float) -> float:
            alpha, beta = np.exp(np.minimum(crossing.at + part * along, self.high)).tolist()
            states[part] = self.state(alpha, beta, rtol)
            return states[part].speed_m_s / self.speed_m_s - 1 if states[part] else math.nan

        width = float(half[crossing.axis])
        try:
            root = float(brentq(miss, -width, width, xtol=1e-15))  # pyright: ignore[reportArgumentType]
        except ValueError:  # no crossing any more, or no state
            return None
        if root not in states:
            miss(root)
        found: Any = states[root]
        value = math.log(max(self.search.watts(found), 1e-300))
        margin = min(self.search.margins(found.gait).values(), default=math.inf)
        shape = GaitShape.of(found.gait.alpha_rad, found.gait.beta_rad)
        return Point(np.array(shape), value, margin, found)


def _on_edges(mesh: Array, miss: Array, watts: Array, axis: int) -> list[_Crossing]:
    """Return where the edges along an axis cross zero, by straight lines."""
    one, other = (slice(None, -1), slice(1, None))
    first, second = (
        ((one, slice(None)), (other, slice(None)))
        if axis == 0
        else ((slice(None), one), (slice(None), other))
    )
    crossed = miss[first] * miss[second] <= 0
    part = (miss[first] / (miss[first] - miss[second] + 1e-300))[crossed]
    cost = watts[first][crossed] * (1 - part) + watts[second][crossed] * part
    at = mesh[first][crossed] * (1 - part)[:, None] + mesh[second][crossed] * part[:, None]
    return [_Crossing(float(c), a, axis) for c, a in zip(cost, at, strict=True)]


def _apart(crossings: list[_Crossing], step: Array) -> list[_Crossing]:
    """Return the cheapest of some sorted crossings that are some steps from each other."""
    kept: list[_Crossing] = []
    for one in crossings:
        if all(np.abs((one.at - other.at) / step).max() > _APART for other in kept):
            kept.append(one)
    return kept[:_STARTS]
