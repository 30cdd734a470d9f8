"""A table of gaits over shapes and rates, and the cheapest shapes that it shows at one speed."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..model.core_model import core_model
from ..model.gait import Gait
from ..model.ground import Ground
from ..model.robot import Robot
from ..periodic.at_speed import COSTS, SpeedState
from ..periodic.steady import MAX_ELEMENTS
from .limits import GaitLimits
from .quadratic_search import Point, Valley
from .shape_search import Candidate, GaitShape, NearShapes, on_threads

Array = NDArray[np.float64]
# Solves one column of a table: amplitudes (A,), one lag, rates (W,) -> speed and cost, (A, W).
Column = Callable[[Array, float, Array], tuple[Array, Array]]
_BEYOND = 2.0  # of the servos' speed: faster gaits help no interpolation and are not solved
_STILL = 1e-6  # of body length times rate: a lower speed is noise of the solver
_ROUNDING = 1 + 1e-9  # an amplitude at its limit, after exp(log(limit))
_FINE_WITHIN = 1.02  # of the cheapest: what lines between rates may hide
_FINE_RTOL = 1e-3
_SAME_START, _SAME_END = 0.25, 0.15  # e-folds of shape: one start, one valley
_LEAST_LED, _FAR_LED = 0.006, 0.3  # e-folds of shape: the least first box; optima lead no farther
_BENDS = 0.06  # e-folds of shape for one of speed: what a tangent alone may miss
_BENT, _BENT_KNOWN = 0.5, 0.03  # e-folds of cost, for one of speed squared: doubt of a slope
_LEAST_DOUBT = 1e-3  # e-folds of cost
_DOUBT = 0.05  # e-folds of cost: how much the factor of a valley may change with the speed
_PENALTY = 8.0  # cost of a limit exceeded by a factor f rises as f^8, so valleys inside win


class GaitTable:
    """Speeds and costs of gaits over shapes and rates.

    Parameters
    ----------
    robot, ground, cost, limits
        As in `least_power_gait`.
    alpha_rad, beta_rad
        Amplitude and lag of the joints, broadcast to (S, L); each column has one lag.
    rtol
        Relative accuracy of the speeds.
    column
        Solves one column; the exact model unless given.

    Attributes
    ----------
    omega_rad_s : (W,)
        Rates, none at first; see `add_rates`.
    speed_m_s, cost_w : (S, L, W)
        NaN where there is no solution.
    """

    def __init__(
        self,
        robot: Robot,
        ground: Ground,
        cost: str,
        limits: GaitLimits,
        alpha_rad: Array,
        beta_rad: Array,
        rtol: float,
        column: Column | None = None,
    ) -> None:
        self.robot, self.ground, self.cost, self.limits = robot, ground, cost, limits
        self.alpha_rad, self.beta_rad = np.broadcast_arrays(alpha_rad, beta_rad)
        self.omega_rad_s = np.empty(0)
        self.speed_m_s = self.cost_w = np.empty((*self.alpha_rad.shape, 0))
        self._rtol, self._column = rtol, column or self._exact_column

    def add_rates(self, rates: Array, shapes: NDArray[np.bool_] | None = None) -> None:
        """Solve all shapes, or those of a mask (S, L), at rates in ascending order, rad/s."""
        allowed = self.alpha_rad <= min(self.limits.joint_angle_rad, math.pi) * _ROUNDING
        if shapes is not None:
            allowed &= shapes
        speed, cost = np.full((2, *self.alpha_rad.shape, rates.size), np.nan)

        def solve(j: int) -> None:
            rows = np.flatnonzero(allowed[:, j])
            alpha = np.minimum(self.alpha_rad[rows, j], math.pi)
            most = _BEYOND * self.limits.servo_speed_rad_s / alpha.min(initial=math.pi)
            count = int(np.searchsorted(rates, most))
            if rows.size and count:
                speed[rows, j, :count], cost[rows, j, :count] = self._column(
                    alpha, float(self.beta_rad[0, j]), rates[:count]
                )

        columns = range(self.alpha_rad.shape[1])
        if self.ground.smooth:  # they take less than starting threads does
            for j in columns:
                solve(j)
        else:
            on_threads(solve, columns)
        self.omega_rad_s = np.concatenate([self.omega_rad_s, rates])
        self.speed_m_s = np.concatenate([self.speed_m_s, speed], axis=2)
        self.cost_w = np.concatenate([self.cost_w, cost], axis=2)

    def fill(self, first: Array, last: Array) -> None:
        """Solve shapes at their rates from number `first` up to, not including, `last`, (S, L)."""

        def solve(place: list[int]) -> None:
            i, j = place
            here = slice(int(first[i, j]), int(last[i, j]))
            alpha = np.minimum(self.alpha_rad[i : i + 1, j], math.pi)
            rates, beta = self.omega_rad_s[here], float(self.beta_rad[i, j])
            speed, cost = self._column(alpha, beta, rates)
            self.speed_m_s[i, j, here], self.cost_w[i, j, here] = speed[0], cost[0]

        allowed = self.alpha_rad <= min(self.limits.joint_angle_rad, math.pi) * _ROUNDING
        on_threads(solve, np.argwhere(allowed & (last > first)).tolist())

    def _exact_column(self, alpha: Array, beta: float, rates: Array) -> tuple[Array, Array]:
        """Return speed and cost by the exact model; on dry ground rough ones."""
        models = [core_model(self.robot, self.ground, Gait(float(a), beta, 1.0)) for a in alpha]
        table = _core.sweep(
            models,
            rates.tolist(),
            self._rtol,
            self.cost != "power",
            MAX_ELEMENTS,
            1,
            None,
            rough=True,
        )
        v, watts, good = table[..., 0], table[..., 1 + COSTS.index(self.cost)], table[..., 10] > 0.5
        v = np.where(v > _STILL * rates * self.robot.links * self.robot.link_length_m, v, 0.0)
        return np.where(good, v, np.nan), np.where(good, watts, np.nan)

    def at_speed(self, speed_m_s: float) -> tuple[Array, Array]:
        """Return rate and cost of every shape at a speed, (S, L); NaN where none gives it.

        Straight lines in log-log between the two rates that enclose the speed; the lowest such
        pair of rates counts.
        """
        if self.omega_rad_s.size < 2:
            return np.full(self.alpha_rad.shape, np.nan), np.full(self.alpha_rad.shape, np.nan)
        slow, cost = self.speed_m_s <= speed_m_s, self.cost_w[:, :, :-1]
        here = slow[:, :, :-1] & (self.speed_m_s >= speed_m_s)[:, :, 1:]
        here &= (cost > 0) & (cost < np.inf)
        i, j = np.indices(self.alpha_rad.shape)
        k = here.argmax(axis=2)
        x = np.log(self.omega_rad_s)
        with np.errstate(divide="ignore", invalid="ignore"):
            y0, y1 = (np.log(self.speed_m_s[i, j, of] / speed_m_s) for of in (k, k + 1))
            q0, q1 = (np.log(self.cost_w[i, j, of]) for of in (k, k + 1))
            f = np.clip(-y0 / (y1 - y0), 0, 1)
            f = np.where(np.isfinite(f), f, 1.0)
            rate, watts = np.exp(x[k] + f * (x[k + 1] - x[k])), np.exp(q0 + f * (q1 - q0))
        none = ~here.any(axis=2)
        rate[none] = watts[none] = np.nan
        return rate, watts

    def candidates(self, speed_m_s: float, most: int, within: float) -> list[Candidate]:
        """Return the cheapest shapes that no neighbour undercuts, at most `within` times the best.

        A shape beyond a limit of servo speed or rate has a penalty. So where no shape keeps the
        limits, those nearest to them are returned. Their costs include the penalty.
        """
        rate, watts = self.at_speed(speed_m_s)
        with np.errstate(invalid="ignore", divide="ignore"):
            excess = np.log(
                np.maximum.reduce(
                    [
                        self.alpha_rad * rate / self.limits.servo_speed_rad_s,
                        self.limits.omega_low_rad_s / rate,
                        rate / self.limits.omega_high_rad_s,
                    ]
                )
            )
        price = np.where(np.isnan(watts), np.inf, watts * np.exp(_PENALTY * np.maximum(excess, 0)))
        picked = valleys(price, most)
        return [
            self._candidate(i, j, rate, price)
            for cost, (i, j) in picked
            if cost <= within * picked[0][0]
        ]

    def shapes_within(self, speed_m_s: float, within: float) -> list[Candidate]:
        """Return all shapes that cost at most `within` times the best, cheapest first."""
        rate, watts = self.at_speed(speed_m_s)
        good = np.argwhere(watts <= within * np.nanmin(watts, initial=math.inf)).tolist()
        return sorted(self._candidate(i, j, rate, watts) for i, j in good)

    def _candidate(self, i: int, j: int, rate: Array, watts: Array) -> Candidate:
        shape = GaitShape.of(float(self.alpha_rad[i, j]), float(self.beta_rad[i, j]))
        return Candidate(float(watts[i, j]), shape, float(rate[i, j]))


class Optimum(NamedTuple):
    """Hold a valley's lowest point at a speed.

    at: swing, lag and ln rate. tangent: its change with ln speed. slope: of ln cost, likewise.
    None where they are not known.
    """

    log_speed: float
    at: Array
    value: float = math.nan
    slope: float | None = None
    tangent: Array | None = None

    @classmethod
    def of(cls, valley: Valley, speed_m_s: float, cost: str) -> Optimum:
        """Return a valley's lowest point with what is known of its change with the speed."""
        end, _, tangent = valley
        state: Any = end.data
        rate = math.log(state.gait.omega_rad_s) if state is not None else math.nan
        slope = state.slopes[1 + COSTS.index(cost)] if isinstance(state, SpeedState) else None
        return cls(math.log(speed_m_s), np.append(end.at, rate), end.value, slope, tangent)


def led(known: Sequence[Optimum], log_speed: float) -> tuple[Array, float] | None:
    """Return where the optima of other speeds lead, and how far off that may be, e-folds of shape.

    The tangent of the last leads, or the cubic by the last two with their tangents. Their parabola
    leads elsewhere: so far off may it be.
    """
    x, last, _, _, tangent = known[-1]
    if tangent is None:
        return None
    earlier = known[-2].tangent if len(known) > 1 else None
    ahead = log_speed - x
    at, doubt = last + ahead * tangent, _BENDS * abs(ahead)
    if earlier is not None:
        step = x - known[-2].log_speed
        bend = (tangent - earlier) / (2 * step)
        parabola = at + ahead**2 * bend
        twist = known[-2].at - (last - step * tangent + step**2 * bend)
        at = parabola - twist * ahead**2 / step**2 * (2 * ahead / step + 3)
        doubt = float(np.abs(at - parabola)[:2].max())
    if np.abs(at - last)[:2].max() > _FAR_LED:
        return None
    return at, max(doubt, _LEAST_LED)


class _Valley(NamedTuple):
    """Hold a valley's start, e-folds of shape, its end, and how far that is below the table."""

    start: Array
    below: float
    end: Optimum


class FollowedValleys:
    """Remember how far below the table valleys ended at other speeds: what to follow again.

    A valley's floor lies below the table's shape by a factor that changes little with the speed.
    """

    def __init__(self) -> None:
        self._known: list[_Valley] = []

    def add(self, start: Candidate, end: Optimum) -> None:
        """Keep what following a candidate led to."""
        if np.isfinite(end.value):
            below = math.log(start.watts) - end.value
            self._known.append(_Valley(np.array(start.shape), below, end))

    def worth(self, start: Candidate, best: Point, steps: Array, log_speed: float) -> bool:
        """Tell whether a candidate may end below the best, in another valley than that.

        steps: of the table, e-folds of shape; a dearer candidate nearer to the best than that lies
        in its valley.
        """
        off = np.abs(best.at - np.array(start.shape))
        if np.all(off < steps) and math.log(start.watts) > best.value:
            return False
        near = self._near(start)
        if not near:
            return True
        if np.abs(near[-1].end.at[:2] - best.at).max() < _SAME_END:
            return False
        least = _least_value([valley.end for valley in near], log_speed)
        if least is None:
            least = math.log(start.watts) - near[-1].below - _DOUBT
        return least < best.value

    def led(self, start: Candidate, log_speed: float) -> tuple[Candidate, float] | None:
        """Return where a valley's ends lead, and the first box there; None: not known."""
        near = self._near(start)
        found = led([valley.end for valley in near], log_speed) if near else None
        if found is None:
            return None
        at, radius = found
        return Candidate(start.watts, GaitShape(*at[:2].tolist()), math.exp(at[2])), radius

    def _near(self, start: Candidate) -> list[_Valley]:
        at = np.array(start.shape)
        near = [known for known in self._known if np.abs(known.start - at).max() < _SAME_START]
        return [
            known
            for known in near
            if np.abs(known.end.at[:2] - near[-1].end.at[:2]).max() < _SAME_END
        ]


def _least_value(known: Sequence[Optimum], log_speed: float) -> float | None:
    """Return what a valley's ln cost is at another speed at least, by its slopes; None: unknown."""
    last = known[-1]
    if last.slope is None:
        return None
    ahead, bend, doubt = log_speed - last.log_speed, 0.0, _BENT
    if len(known) > 1 and (before := known[-2]).slope is not None:
        bend = (last.slope - before.slope) / (last.log_speed - before.log_speed)
        doubt = _BENT_KNOWN + abs(bend) / 4
    value = last.value + ahead * (last.slope + ahead * bend / 2)
    return value - doubt * ahead**2 - _LEAST_DOUBT


def valleys(price: Array, most: int) -> list[tuple[float, list[int]]]:
    """Return price and place of entries that no neighbour undercuts, cheapest first; inf: none."""
    padded = np.pad(price, 1, constant_values=np.inf)
    around = [
        padded[1 + i : 1 + i + price.shape[0], 1 + j : 1 + j + price.shape[1]]
        for i in (-1, 0, 1)
        for j in (-1, 0, 1)
        if i or j
    ]
    local = np.isfinite(price) & (price <= np.min(around, axis=0))
    return sorted(zip(price[local].tolist(), np.argwhere(local).tolist(), strict=True))[:most]


def refined_valleys(
    search: NearShapes, best: Point, speed_m_s: float, width: float, half: int, most: int
) -> list[Candidate]:
    """Return the cheapest shapes that no neighbour undercuts, within e^width of a point's.

    On dry ground, kinks make small valleys in a large one; this finer table shows them. It is
    solved from its middle outwards: each ring starts from what the one inside tells.
    """
    state: Any = best.data
    low, high = search.bounds()
    price = np.full((2 * half + 1, 2 * half + 1), np.inf)
    points: dict[tuple[int, int], Point] = {}
    places = np.argwhere(np.isfinite(np.zeros_like(price))) - half
    for ring in range(half + 1):
        here = places[np.abs(places).max(axis=1) == ring]
        shapes = best.at + here * (width / half)
        inside = ((shapes >= low) & (shapes <= high)).all(axis=1)
        found = search.points(list(shapes[inside]), speed_m_s, state.gait.omega_rad_s, _FINE_RTOL)
        for (i, j), point in zip((here[inside] + half).tolist(), found, strict=True):
            points[i, j] = point
            if not point.better[0]:
                price[i, j] = math.exp(point.value)
    return [
        _of_point(points[i, j])
        for cost, (i, j) in valleys(price, most)
        if cost <= _FINE_WITHIN * price.min()
    ]


def _of_point(point: Point) -> Candidate:
    state: Any = point.data
    return Candidate(math.exp(point.value), GaitShape(*point.at.tolist()), state.gait.omega_rad_s)
