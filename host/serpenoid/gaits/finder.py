"""The search for the gait of least power at a speed: from a table down its valleys, then closer."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Sequence
from contextlib import suppress
from copy import copy
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.optimize import minimize, minimize_scalar

from ..base.checks import check_choice, check_number
from ..base.errors import BadInput, NotConverged, SerpenoidError
from ..base.rows import Result, Row, detail, two_digits
from ..model.core_model import check_parts
from ..model.gait import Gait
from ..model.ground import Ground
from ..model.robot import Robot
from ..periodic.steady import Steady, check_ground, state_near, steady_gait
from ..simulation.steady_springs import steady_springs
from .limits import LIMIT_NAMES, GaitLimits, peak_torque_nm
from .shapes import COSTS, FINE, STATES, Array, Point, angles_of, better, near_root, rate_at_speed
from .table import GaitTable

ANY = GaitLimits()
# no snake robot comes near; without a limit of servos or rate (the first) it takes minutes beyond
MOST_LENGTHS_A_SECOND = 100.0, 1e4
LEAST_LENGTHS_A_SECOND = 1e-6  # on dry ground states of slower gaits drown in rounding
FIRST = 0.15  # e-folds of shape: the first simplex, half a step of the table; later ones are half
ROUGH = 0.02  # e-folds of shape: where the first descents end, and what lies on a limit for them
AROUND = 12  # shapes of a ring around the best, half a radius from each to the next
AS_LOW = 0.1  # e-folds of cost: a ring's shape this much above the best may lead to a lower one
ROUNDS = 3  # closer searches at most: each gains less than a third of the one before
_MISSED = 0.05  # of the speed: a precise state that is farther off shows the rough ones to be wrong
_AT_REST = (
    "no gait travels at all: of two links' one joint a stroke undoes the one before it; take three "
    "links or more"
)
_NEAR_MISS = 10  # times the accuracy asked for: a state this good still ranks shapes


@dataclass(frozen=True, slots=True)
class LeastPower(Result):
    """Hold the gait with the least power for a speed.

    Attributes
    ----------
    gait
        The gait found.
    power_w
        The cost that was minimized, W.
    speed_m_s
        Its speed, m/s.
    cost
        "power", "abs_power" or "positive_power".
    steady
        The exact model's periodic state.
    formulation
        "explicit" or "implicit".
    limits, active
        The limits of the search, and those that the gait has reached, in words.
    power_error_w
        How much less power there may be, W: solved_error_w and what the search may have missed.
    solved_error_w
        Error of this gait's power, W.
    basins
        Number of separate valleys of shapes that were searched.
    runner_up_w
        Power of the second best valley, W; inf if there was one valley.
    evaluations
        Periodic states solved in the search, without those of tables.

    Examples
    --------
    >>> robot = sn.Robot(links=6, link_mass_kg=1.0, link_length_m=0.12)
    >>> ground = sn.Ground(ct=0.1, cn=10.0)
    >>> best = sn.least_power_gait(robot, ground, speed_m_s=0.1)
    >>> round(best.gait.omega_rad_s, 1)
    1.8
    """

    gait: Gait
    power_w: float
    speed_m_s: float
    cost: str
    steady: Steady
    formulation: str = "explicit"
    limits: GaitLimits = ANY
    active: tuple[str, ...] = ()
    power_error_w: float = 0.0
    solved_error_w: float = 0.0
    basins: int = 1
    runner_up_w: float = math.inf
    evaluations: int = 0

    def in_words(self) -> str:
        """Return the gait and its power in the words of a builder."""
        return cheapest(self.gait, self.power_w)

    def rows(self) -> list[Row]:
        """Return power, speed, limits reached, and what the search may have missed."""
        return [
            Row(f"least {self.cost}", "W", self.power_w),
            *self.steady.rows(),
            Row("limits reached", "", words=", ".join(self.active) or "none"),
            detail("some gait may need less, by", "W", self.power_error_w),
        ]


def cheapest(gait: Gait, power_w: float) -> str:
    """Return a gait and its power in the words of a builder."""
    alpha, beta = math.degrees(gait.alpha_rad), math.degrees(gait.beta_rad)
    frequency_hz = two_digits(gait.omega_rad_s / math.tau)
    power = two_digits(power_w)
    return f"The gait of least power: {alpha:.0f}°/{beta:.0f}° at {frequency_hz} Hz, {power} W."


class Finder:
    """Finds the cheapest gaits of one robot on one ground, for any speed, from one table.

    springs: stiffness and damping of the implicit formulation's joints; None: the exact model.
    """

    def __init__(
        self,
        robot: Robot,
        ground: Ground,
        speeds: Sequence[float],
        cost: str,
        limits: GaitLimits = ANY,
        rtol: float | None = None,
        springs: tuple[float, float] | None = None,
    ) -> None:
        check_parts(robot, ground)
        limited = min(limits.servo_speed_rad_s, limits.omega_high_rad_s) < math.inf
        lengths = MOST_LENGTHS_A_SECOND[bool(limited)]
        for speed in speeds:
            check_number("speed_m_s", speed)
            least, most = (x * robot.body_length_m for x in (LEAST_LENGTHS_A_SECOND, lengths))
            if not least <= speed <= most:
                limit = "" if limited or speed < least else "; or limit the speed of the servos"
                raise BadInput(
                    f"speed_m_s is {speed:g}; it must be at least {least:.3g} and at most "
                    f"{most:.4g}: no snake robot makes less than {LEAST_LENGTHS_A_SECOND:g} or "
                    f"more than {lengths:g} lengths of its body a second{limit}"
                )
        check_choice("cost", cost, COSTS)
        smooth = ground.smooth and springs is None
        # of the searched states, of their speeds, and of places where a descent ends
        precise = (1e-8, 1e-7, 1e-4) if smooth else (STATES, STATES / 10, ROUGH / 4)
        self.state_rtol, self.miss, self.ends = precise
        self.rounding = self.miss / 2  # e-folds beyond a limit that count as on it
        self.rtol = rtol or (
            1e-4 if springs else FINE if not ground.smooth else 1e-10 if cost == "power" else 1e-8
        )
        check_ground(ground, self.rtol)
        self.robot, self.ground, self.cost, self.limits = robot, ground, cost, limits
        self.springs, self.solved = springs, Counter[str]()
        self.speed: Callable[[Gait, Any], float] = lambda _, state: state.speed_m_s
        self.table = GaitTable(robot, ground, cost, limits, speeds)

    @property
    def at_rest(self) -> bool:
        """Tell whether symmetry keeps all gaits in place: one joint, wheels alike both ways."""
        return self.robot.links == 2 and not self.ground.ratchet

    def solve(self, gait: Gait, rtol: float, start: Any = None) -> Any:
        """Return a gait's state, also one that is a near miss, or None. start: a state near it."""
        self.solved["states"] += 1
        if self.springs is None:
            powers = self.cost != "power"
            rough = start is not None and not self.ground.smooth
            state = state_near(self.robot, self.ground, gait, rtol=rtol, powers=powers, start=start)
            most = math.inf if rough else _NEAR_MISS * rtol
            return state if state.error_estimate < most else None
        k, c = self.springs
        with suppress(SerpenoidError):
            return steady_springs(
                self.robot,
                self.ground,
                gait,
                rtol=rtol,
                joint_stiffness_n_m=k,
                joint_damping_n_s_m=c,
            )
        return None

    def watts(self, state: Any) -> float:
        """Return the cost of a state, W."""
        return getattr(state, f"{self.cost}_w")

    def margins(self, gait: Gait) -> dict[str, float]:
        """Return by how many e-folds a gait is below each limit."""
        return self.limits.margins(gait, self.torque_nm(gait))

    def torque_nm(self, gait: Gait) -> float:
        """Return the gait's peak torque where there is a limit to it, else 0."""
        if self.limits.servo_torque_nm == math.inf:
            return 0.0
        return peak_torque_nm(self.robot, self.ground, gait)

    def point(self, shape: Array, speed: float, near: Point, rtol: float | None = None) -> Point:
        """Return a shape at the rate near another's that gives the speed."""
        alpha, beta = angles_of(shape)
        most = self.limits.joint_angle_rad
        alpha = most if most < alpha <= most * (1 + self.rounding) else alpha
        if not 0 < alpha <= math.pi:
            return Point(shape)

        last = near.state

        def state(x: float) -> tuple[float, float]:
            nonlocal last
            gait = Gait(alpha, beta, math.exp(x))
            solved = self.solve(gait, rtol or self.state_rtol, None if rtol else last)
            if solved is None:
                return math.nan, math.nan
            last = solved
            ratio, watts = self.speed(gait, solved) / speed, self.watts(solved)
            return math.log(max(ratio, 1e-300)), math.log(max(watts, 1e-300))

        end = rate_at_speed(state, math.log(near.rate), rtol or self.miss)
        if end is None:
            return Point(shape)
        if end[2] > 0:
            return Point(shape, None, end[1], -end[2])
        gait = Gait(alpha, beta, math.exp(end[0]))
        margin = min(self.margins(gait).values(), default=math.inf)
        return Point(shape, gait, end[1], margin + self.rounding, last)

    def bounds(self) -> tuple[Array, Array]:
        """Return the least and greatest coordinates that are searched."""
        least_lag = min(0.08, 0.8 / self.robot.links)
        # a standing wave, of 180 degrees, goes nowhere without a ratchet
        most_lag = math.radians(180.0 - 1e-3 if self.ground.ratchet else 175.0)
        low, high = np.tan(np.array([least_lag, most_lag]) / 2)
        return np.log([math.radians(1.0), low]), np.log([math.radians(150.0), high])

    def descend(self, speed: float, start: Point, size: float, ends: float) -> Point:
        """Return the lowest point of a valley, also along the limits that it reaches.

        size: of the first simplex, e-folds of shape; below 0 it looks the other way.
        """
        search = copy(self)
        search.miss = max(self.miss, ends**2 / 4)  # a valley's power goes with the square, too
        valley = Valley(search, speed, start)
        how = {
            "initial_simplex": start.shape + size * np.eye(3, 2, -1),
            "xatol": ends,
            "fatol": ends**2,
            "maxfev": 90,
        }
        minimize(
            lambda shape: valley.point(shape).price, start.shape, method="Nelder-Mead", options=how
        )
        end = min(valley.points, key=lambda point: point.price)
        if end.gait is not None:
            for name, margin in self.margins(end.gait).items():
                if margin < ROUGH:
                    valley.along(name, end, abs(size), ends)
        return min(valley.points, key=better)

    def front(self, speeds: Sequence[float]) -> list[LeastPower | NotConverged]:
        """Return the cheapest gait of each speed, in ascending order, or why there is none.

        Each is searched from the table, then from the gaits of the slower and the faster speed.
        """
        if self.at_rest:
            return [NotConverged(_AT_REST) for _ in speeds]
        search, exact = self.with_springs if self.springs else self.closest, copy(self)
        exact.springs = None
        return [
            search(v, sorted(ends, key=better))
            for v, ends in zip(speeds, exact.valleys(speeds), strict=True)
        ]

    def valleys(self, speeds: Sequence[float]) -> list[list[Point]]:
        """Return where the first descents of each speed end."""
        ends = [
            [self.descend(v, start, FIRST, ROUGH) for start in self.table.starts(v)] for v in speeds
        ]
        places = range(len(speeds))
        for known, k in [*pairwise(places), *pairwise(reversed(places))]:
            best = min(ends[known], key=better, default=Point(np.zeros(2)))
            if best.gait is not None:
                rate = best.rate * speeds[k] / speeds[known]
                start = replace(best, gait=replace(best.gait, omega_rad_s=rate))
                ends[k].append(self.descend(speeds[k], start, FIRST / 2, ROUGH))
        return ends

    def with_springs(self, speed: float, ends: list[Point]) -> LeastPower | NotConverged:
        """Return the lowest gait by springs and dampers, from the exact model's valleys.

        Springs move a valley little, and their states cost a hundred times as much: a descent is
        short, and starts once more from the other side. What that gains may be missed again, and
        what states err.
        """
        first = [
            self.descend(speed, end, FIRST / 4, ROUGH)
            for k, end in enumerate(ends)
            if end.price < ends[0].price + AS_LOW
            and all(math.dist(end.shape, other.shape) > FIRST for other in ends[:k])
        ]
        if not first or min(first, key=better).margin < 0:
            return self.unreachable(speed, first)
        lowest, *others = sorted(first, key=better)
        best = self.descend(speed, lowest, -FIRST / 8, self.ends)
        gap = abs(lowest.value - best.value) + self.state_rtol
        return self.finish(speed, min(best, lowest, key=better), gap, others)

    def closest(self, speed: float, ends: list[Point]) -> LeastPower | NotConverged:
        """Return the lowest of some valleys, searched more closely, or why there is none.

        Descents from the three lowest shapes of a ring start again from their lowest end while they
        gain. What the last gained, and how far apart their lowest ends are, says what may be
        missed.
        """
        if not ends or ends[0].margin < 0:
            return self.unreachable(speed, ends)
        ends = sorted([*ends, *self.around(speed, ends[0])], key=better)
        best, radius, gap = self.in_order(speed, ends[0]), FIRST / 2, math.inf
        for _ in range(ROUNDS):
            if gap < STATES:
                break
            starts = sorted(self.ring(speed, best, radius), key=better)[:3]
            lows = sorted(
                [self.descend(speed, start, -radius / 2, self.ends) for start in starts], key=better
            )
            gap = abs(best.value - lows[0].value) + lows[1].value - lows[0].value
            best, radius = min([best, lows[0]], key=better), radius / 2
        return self.finish(speed, best, gap + self.miss, ends[1:])

    def around(self, speed: float, best: Point) -> list[Point]:
        """Return where descents end that start from the low shapes of two rings around the best.

        A flat valley may have low places that are closer to each other than the table's starts.
        """
        return [
            self.descend(speed, point, FIRST / 2, ROUGH)
            for radius in (FIRST, 2 * FIRST)
            for points in [self.ring(speed, best, radius)]
            for k, point in enumerate(points)
            if point.price <= min(points[k - 1].price, points[(k + 1) % AROUND].price)
            and point.price < best.price + AS_LOW
        ]

    def ring(self, speed: float, best: Point, radius: float) -> list[Point]:
        """Return points on a circle of shapes around the best; its rate where they have none."""
        angles = math.tau / AROUND * np.arange(AROUND)
        shapes = best.shape + radius * np.column_stack([np.cos(angles), np.sin(angles)])
        points = [self.point(np.clip(shape, *self.bounds()), speed, best) for shape in shapes]
        return [replace(point, gait=point.gait or best.gait) for point in points]

    def in_order(self, speed: float, best: Point) -> Point:
        """Return the best gait, or a cheaper one that a search shows which must not beat it.

        Such are the searches for another kind of power, and within narrower limits where the best
        has reached one of a joint or a servo. If one of their gaits is cheaper, the search has
        missed a valley; it goes on from there.
        """
        other = copy(self)
        other.cost = "positive_power" if self.cost == "abs_power" else "abs_power"
        end = other.descend(speed, best, FIRST, ROUGH)
        rivals = [self.point(end.shape, speed, end)] if end.gait is not None else []
        assert best.gait is not None
        reached = {
            name: getattr(self.limits, name) * math.exp(-FIRST)
            for name, margin in self.margins(best.gait).items()
            if margin < ROUGH and not name.startswith("omega")
        }
        if reached:
            narrow, table = copy(self), copy(self.table)
            narrow.limits = table.limits = replace(self.limits, **reached)
            rivals += [narrow.descend(speed, start, FIRST, ROUGH) for start in table.starts(speed)]
        return min([best, *rivals], key=better)

    def finish(
        self, speed: float, best: Point, gap: float, others: list[Point]
    ) -> LeastPower | NotConverged:
        """Solve the best once more, to the accuracy that was asked for."""
        end = self.point(best.shape, speed, best, self.rtol)
        if end.gait is None or abs(end.value - best.value) > STATES:
            # beyond a fold of the speed, or a jump of the power, which rougher states did not show
            finer = copy(self)
            finer.state_rtol = finer.miss = self.rtol
            end = min([end, finer.descend(speed, best, self.ends, self.ends / 10)], key=better)
        gait = end.gait or best.gait
        assert gait is not None
        gap += abs(end.value - best.value)
        state = self.solve(gait, self.rtol)
        if state is None or not abs(state.speed_m_s / speed - 1) < _MISSED:
            return self.unreachable(speed, [])
        watts = self.watts(state)
        others = [p for p in others if p.margin >= 0 and math.dist(p.shape, best.shape) > FIRST]
        numerical = getattr(state, f"{self.cost}_error_w") + 2 * state.error_estimate * watts
        # power goes as speed squared or cubed
        gap += 3 * abs(state.speed_m_s / speed - 1)
        exact = (
            state
            if self.springs is None and self.cost != "power"
            else steady_gait(
                self.robot,
                self.ground,
                gait,
                rtol=max(self.rtol, 1e-8 if self.springs is None else 1e-6),
            )
        )
        return LeastPower(
            gait,
            watts,
            state.speed_m_s,
            self.cost,
            exact,
            "explicit" if self.springs is None else "implicit",
            limits=self.limits,
            active=self.limits.active(gait, self.torque_nm(gait)),
            power_error_w=numerical + watts * min(gap, 1.0),
            solved_error_w=numerical,
            basins=1 + len(others),
            evaluations=self.solved["states"],
            runner_up_w=watts * math.exp(others[0].value - best.value) if others else math.inf,
        )

    def unreachable(self, speed: float, tried: list[Point]) -> NotConverged:
        """Return the error that says how fast the robot can go, or what the speed would need."""
        v, alpha, beta, rate = self.table.fastest()
        fastest_rate = min(self.table.highest_rate, self.limits.omega_high_rad_s)
        within = f"within the limits ({self.limits.in_words()})"
        gait = f"alpha {math.degrees(alpha):.3g} deg, beta {math.degrees(beta):.3g} deg"
        if not v > 1e-9 * self.robot.body_length_m * rate:
            return NotConverged(
                f"no gait travels at all {within}: ask for wider limits; three links and friction "
                "that is greater across them than along them are needed, too"
            )
        if v >= speed:  # reached, but beyond what the servos hold, or at other rates
            gaits = [point.gait for point in tried if point.gait is not None]
            return NotConverged(
                f"no gait of {speed:g} m/s was found {within}, though some are faster: {v:.3g} m/s "
                f"at {gait} and {rate:.3g} rad/s, whatever the torque"
                f"{self._needed(gaits)}; ask for a wider range of rates "
                "or more torque"
            )
        return NotConverged(
            f"no gait reaches {speed:g} m/s {within} at up to "
            f"{fastest_rate:.3g} rad/s; the fastest found"
            f"{' by the exact model' if self.springs else ''} makes {v:.3g} m/s, at {gait} and "
            f"{rate:.3g} rad/s; ask for less speed, or wider limits"
        )

    def _needed(self, gaits: list[Gait]) -> str:
        """Return in words which limit the gaits break least, and what it would have to be."""
        worst = [min((margin, name) for name, margin in self.margins(g).items()) for g in gaits]
        if not worst or max(worst)[0] >= 0:
            return ""
        short, name = max(worst)
        way = "lower" if name == "omega_low_rad_s" else "higher"
        more = 100 * math.expm1(-short)
        return f"; the nearest of {len(gaits)} needs a {LIMIT_NAMES[name]} {more:.3g} % {way}"


class Valley:
    """One descent: the points looked at, and the rates that they tell of others."""

    def __init__(self, finder: Finder, speed: float, start: Point) -> None:
        self.finder, self.speed, self.points, self.first = finder, speed, [], start

    def point(self, shape: Array) -> Point:
        """Return the point of a shape, from the rate of the nearest one known."""
        shape = np.clip(shape, *self.finder.bounds())
        known = [p for p in self.points if p.gait is not None]
        near = min(known, key=lambda p: math.dist(p.shape, shape), default=self.first)
        self.points.append(self.finder.point(shape, self.speed, near))
        return self.points[-1]

    def along(self, name: str, start: Point, radius: float, ends: float) -> None:
        """Look along the curve of shapes where a limit is just reached, near a start.

        Along the limit's tangent; each point is put onto the limit along its normal.
        """

        def margin(shape: Array) -> float:
            gait = self.point(shape).gait
            return math.nan if gait is None else self.finder.margins(gait)[name]

        start_margin = margin(start.shape)
        slopes = (
            np.array([margin(start.shape + ends * axis) - start_margin for axis in np.eye(2)])
            / ends
        )
        steep = float(np.hypot(*slopes))
        if not 0 < steep < math.inf:
            return
        normal = slopes / steep
        tangent = normal[::-1] * (-1, 1)

        def onto(t: float) -> float:
            base, miss = start.shape + t * tangent, self.finder.rounding
            places = near_root(lambda u: margin(base + u * normal), 0.0, miss, steep)
            return (self.point(base + places[0] * normal) if places else Point(base)).price

        steps = 5 + 2 * round(math.log2(radius / ends))  # each halves what is left, or nearly
        minimize_scalar(
            onto, bracket=(0.0, radius), method="brent", options={"xtol": ends, "maxiter": steps}
        )
