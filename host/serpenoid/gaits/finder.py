"""Follows the valleys of a gait cloud to the gait that costs least power at a speed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from ..model.checks import FORMULATIONS, check_choice, check_number
from ..model.core_model import check_parts
from ..model.errors import NotConverged
from ..model.gait import Gait
from ..model.ground import Ground
from ..model.robot import Robot
from ..periodic.at_speed import COSTS
from ..periodic.steady import Steady, check_ground
from ..simulation.steady_springs import steady_springs
from .fixed_rate import FixedRateSearch
from .gait_cloud import GaitCloud
from .gait_table import FollowedValleys, Optimum, refined_valleys
from .limits import LIMIT_NAMES, GaitLimits
from .quadratic_search import Point, Valley, minimize
from .shape_search import (
    Candidate,
    GaitShape,
    NearShapes,
    ShapeSearch,
    SmoothShapes,
    Solve,
    exact_solver,
)

ANY = GaitLimits()
_MOST_LENGTHS_A_SECOND = 1e4  # a faster wish makes no sense, and the cloud's rates would not end
_LAST_SMOOTH = 0.006  # e-folds of shape: last box on viscous ground, away from limits
_RADIUS, RADIUS_KNOWN = 0.15, 0.08  # first box: half a step of the cloud; round a known gait
_NARROW = 1.2  # ratio of rates: a narrower range is searched at fixed rates
_APART = 0.1  # e-folds of shape: two ends closer than this are one valley
_ROUGHER = 0.3  # the same factor for the valleys of the cloud on dry ground
_ONWARDS = 0.4  # the same for the valley of the gait of another speed
_CLOSER = 4.0  # refinement factor for the best valley on dry ground
_EDGE_TABLE = (0.12, 8)  # e-folds of shape either way, in so many steps; where there is an edge
_FINE_TABLES = (0.25, 4), (0.06, 3), _EDGE_TABLE
_OTHER_TABLES = _FINE_TABLES[1:]  # the same where another valley is cheaper than at that speed
_NEXT_TABLES = (_EDGE_TABLE,)  # the same for a gait found from that of another speed
_MOST_TABLES, _INSIDE = 6, 0.7  # of a width: while the best is farther out than this part of it
_RING, _RING_AT_EDGE, _RING_NEXT = 16, 32, 8  # directions of a walk; of one from another speed
_AT_EDGE = 0.01  # e-folds of cost: a model that expects so much more lies across an edge
_WALK, _WALK_END, _WALK_SHRINK = 0.06, 0.002, 0.4  # e-folds of shape
_WALK_NEXT = 0.02  # the first ring of a gait from another speed
_WALK_GAIN = 1e-4  # e-folds of cost: a smaller gain ends a ring
_SAME_END = 0.15  # e-folds of shape: two ends of one valley
_SMALL_VALLEYS = 2  # followed of each table
_ROUNDING = 1e-9  # body lengths x rate: a slower gait travels by rounding errors alone
_AT_LIMIT = 2e-6  # e-folds of shape: last box beside a limit, on viscous ground
_LIMIT_RTOL = 1e-9  # of speeds and powers there
_LIMITS_WORTH = 2.0  # e-folds of cost at most, for one of a limit
_ONWARDS_GAP = 7e-3  # e-folds: single searches found so much less than one that goes on
_DRY_GAP = 3e-3  # e-folds: brute force found so much less, so no optimum is known better


Tables = Sequence[tuple[float, int]]


@dataclass(frozen=True, slots=True)
class LeastPower:
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
        Power of the second best valley, W; inf if there was one valley. Of a front: as low as that
        valley was followed.
    evaluations
        Periodic states solved in the search, without those of tables.
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


class Finder:
    """Finds the cheapest gaits of one robot on one ground, for any speed, from one cloud."""

    def __init__(
        self,
        robot: Robot,
        ground: Ground,
        cost: str,
        limits: GaitLimits,
        solve: Solve | None,
        speeds: Sequence[float],
        rtol: float,
    ) -> None:
        self.robot, self.ground, self.limits, self.rtol = robot, ground, limits, rtol
        self.exact = solve is None
        solver = solve or exact_solver(robot, ground, powers=cost != "power")
        self.near = NearShapes(robot, ground, solver, cost, limits)  # on dry ground
        self.search = self.near
        if ground.smooth or not self.exact:
            kind = SmoothShapes if self.exact else ShapeSearch
            self.search = kind(robot, ground, solver, cost, limits)
        self.followed = FollowedValleys()
        self.optimum = Optimum(math.nan, np.zeros(3))  # found last
        self.cloud = GaitCloud(robot, ground, cost, limits, speeds)
        self.coarse = 1e-7 if ground.smooth and self.exact else 3e-4  # accuracy of the search
        self.least_gap = self.coarse if ground.smooth else _DRY_GAP
        self.smallest = 0.002 if ground.smooth and self.exact else 0.012

    def follow(
        self,
        start: Candidate,
        radius: float,
        speed: float,
        closer: float = 1.0,
        beat: Point | None = None,
    ) -> Valley:
        """Return the lowest point of a candidate's valley; closer: refinement factor.

        beat: the lowest point of another valley. A way into that one, or too far above, ends.
        """
        low, high = self.search.bounds()
        rtol = max(self.rtol, self.coarse / closer)
        if isinstance(self.search, SmoothShapes):
            valley = self.search.lowest(start, radius, _LAST_SMOOTH, speed, rtol)
            if valley is not None:
                return valley
        evaluate = partial(self.search.points, speed_m_s=speed, guess=start.omega_rad_s, rtol=rtol)
        first = evaluate([np.array(start.shape)])[0]
        end, gap, _ = minimize(evaluate, first, radius, self.smallest / closer, low, high, beat)
        if self.search is self.near and end.data is not None:
            end = self.near.solved(end, speed, rtol)
        if self.exact and self.ground.smooth and not end.better[0] and end.margin < self.smallest:
            # along a limit the cost is no valley: it rises with the distance from the limit
            evaluate = partial(evaluate, rtol=max(self.rtol, _LIMIT_RTOL))
            end = evaluate([end.at])[0]
            end, gap, _ = minimize(evaluate, end, self.smallest, _AT_LIMIT, low, high)
            gap = max(gap, _LIMITS_WORTH * max(end.margin, 0.0))
        return Valley(end, gap)

    def minimize(
        self, speed: float, last: Sequence[Candidate] = (), radius: float = RADIUS_KNOWN
    ) -> LeastPower:
        """Return the cheapest gait; last: where it should be by lower speeds, this far off."""
        if last:
            ends, tried = self._onwards(speed, last, radius)
        else:
            ends, tried = self._from_cloud(speed)
        ends = ends or self.at_fixed_rates(speed)
        if not ends:
            raise self.unreachable(speed, tried)
        first = ends[0].end.at
        ends.sort(key=lambda e: e.end.value)
        if not self.ground.smooth:
            tracked = np.abs(ends[0].end.at - first).max() < _SAME_END
            tables = (_NEXT_TABLES if tracked else _OTHER_TABLES) if last else _FINE_TABLES
            best, gap, _ = self.refined(ends[0].end, speed, tables)
            ends[0] = Valley(best, max(gap, _ONWARDS_GAP) if last else gap)
        self.optimum = Optimum.of(ends[0], speed, self.search.cost)
        return self.finish(speed, ends)

    def _from_cloud(
        self, speed: float, best: Point | None = None
    ) -> tuple[list[Valley], list[Point]]:
        """Return the ends of the cloud's valleys and all points; best: what they must beat."""
        ends, tried = [], []
        rougher = _ROUGHER if self.search is self.near else 1.0
        x = math.log(speed)
        for start in self.cloud.starts(speed):
            steps = self.cloud.steps_at(start.shape) if self.ground.smooth else np.zeros(2)
            if best is None or self.followed.worth(start, best, steps, x):
                led = self.followed.led(start, x)
                valley = self.follow(*(led or (start, _RADIUS)), speed, rougher, best)
                self.followed.add(start, Optimum.of(valley, speed, self.search.cost))
                tried.append(valley.end)
                ends += [] if valley.end.better[0] else [valley]
        return ends, tried

    def _onwards(
        self, speed: float, last: Sequence[Candidate], radius: float
    ) -> tuple[list[Valley], list[Point]]:
        """Return the end of the last gait's valley first, and others that may be cheaper now."""
        start, closer = last[0], 1.0
        if self.search is self.near:
            shapes, rates = [np.array(one.shape) for one in last], [one.omega_rad_s for one in last]
            points = self.near.rated(shapes, speed, rates, self.coarse / _ONWARDS)
            start, closer = last[min(range(len(last)), key=lambda k: points[k].better)], _ONWARDS
        valley = self.follow(start, radius, speed, closer)
        if valley.end.better[0]:
            return self._from_cloud(speed)
        others, tried = self._from_cloud(speed, valley.end)
        return [valley, *others], [valley.end, *tried]

    def at_fixed_rates(self, speed: float) -> list[Valley]:
        """Return the cheapest gaits at the ends and the middle of a narrow range of rates."""
        low, high = self.limits.omega_low_rad_s, self.limits.omega_high_rad_s
        if not 0 < high <= _NARROW * low:
            return []
        rates = np.unique([low, math.sqrt(low * high), high])
        searches = [FixedRateSearch(self.search, float(rate), speed) for rate in rates]
        found = [search.minimize(self.rtol, self.coarse) for search in searches]
        return [Valley(*end) for end in found if end is not None]

    def refined(self, best: Point, speed: float, tables: Tables = _FINE_TABLES) -> Valley:
        """Return the best of a dry valley, where kinks make small valleys in the large one.

        Fine tables of shapes show them, and the best are followed. What the last one gained, or saw
        below, may still be missing.
        """
        best = self.walked(best, speed, _RING_NEXT if tables is _NEXT_TABLES else _RING)
        gap = model_gap = 0.0
        for width, half in tables:
            at_edge = model_gap > _AT_EDGE
            if (width, half) == _EDGE_TABLE and not at_edge:
                break
            before, seen = best.value, math.inf
            for _ in range(_MOST_TABLES):
                middle = best.at
                starts = refined_valleys(self.near, best, speed, width, half, _SMALL_VALLEYS)
                seen = math.log(starts[0].watts) if starts else math.inf
                for start in starts:
                    point, lower, _ = self.follow(start, width / 6, speed, closer=_CLOSER)
                    if point.better < best.better:
                        best, model_gap = point, lower
                if np.abs(best.at - middle).max() < _INSIDE * width:
                    break
            best = self.walked(best, speed, _RING_AT_EDGE if at_edge else _RING)
            gap = before - best.value
            if self.exact:  # the tables are the exact model's
                gap = max(gap, best.value - seen)
        return Valley(best, gap)

    def walked(self, best: Point, speed: float, directions: int) -> Point:
        """Return the end of steps to the lowest point of ever smaller rings: along edges and kinks.

        A quadratic model says nothing beside an edge, where wheels begin to slide.
        """
        turns = 2 * math.pi * np.arange(directions) / directions
        ring = np.stack([np.cos(turns), np.sin(turns)], axis=1)
        low, high = self.search.bounds()
        radius = _WALK_NEXT if directions == _RING_NEXT else _WALK
        while radius >= _WALK_END:
            state: Any = best.data
            points = self.search.points(
                list(np.clip(best.at + radius * ring, low, high)),
                speed,
                state.gait.omega_rad_s,
                max(self.rtol, self.coarse / _CLOSER),
            )
            lowest = min([best, *points], key=lambda p: p.better)
            if lowest is not best and self.search is self.near:
                lowest = self.near.solved(lowest, speed, self.coarse / _CLOSER)
            if lowest.better < best.better and lowest.value < best.value - _WALK_GAIN:
                best = lowest
            else:
                radius *= _WALK_SHRINK
        return best

    def finish(self, speed: float, ends: list[Valley]) -> LeastPower:
        """Solve the best once more, to the accuracy that was asked for."""
        (best, gap, _), search = ends[0], self.search
        rough: Any = best.data
        state = (
            search.at_speed(GaitShape(*best.at), speed, rough.gait.omega_rad_s, self.rtol) or rough
        )
        watts = search.watts(state)
        apart = [p for p, *_ in ends[1:] if np.abs(p.at - best.at).max() > _APART]
        exact, own = self.exact_state(state), _numerical(state, search.cost)
        gap = max(gap, self.least_gap) + 3 * abs(
            state.speed_m_s / speed - 1
        )  # power goes as speed^2
        return LeastPower(
            state.gait,
            watts,
            state.speed_m_s,
            search.cost,
            exact,
            limits=self.limits,
            active=self.limits.active(state.gait, search.torque_nm(state.gait)),
            power_error_w=own + watts * min(gap, 1.0),
            solved_error_w=own,
            basins=1 + len(apart),
            evaluations=search.evaluations,
            runner_up_w=watts * math.exp(apart[0].value - best.value) if apart else math.inf,
        )

    def exact_state(self, state: Any) -> Steady:
        """Return the exact model's state of a gait with all powers, which a search leaves out."""
        if self.exact and self.search.cost != "power":
            return state
        rtol = max(self.rtol, 1e-8) if self.exact else 1e-6
        return exact_solver(self.robot, self.ground, powers=True)(state.gait, rtol)

    def unreachable(self, speed: float, tried: list[Point]) -> NotConverged:
        """Return the error that says how fast the robot can go, or what the speed would need."""
        v, alpha, beta, rate = self.cloud.fastest()
        within = f"within the limits ({self.limits.in_words()})"
        gait = f"alpha {math.degrees(alpha):.3g} deg, beta {math.degrees(beta):.3g} deg"
        if not v > _ROUNDING * self.robot.body_length_m * rate:
            return NotConverged(
                f"no gait travels at all {within}: ask for wider limits; three links and friction "
                "that is greater across them than along them are needed, too"
            )
        if v >= speed:  # reached, but beyond what the servos hold, or at other rates
            states: list[Any] = [point.data for point in tried if point.data is not None]
            return NotConverged(
                f"no gait of {speed:g} m/s was found {within}, though some are faster: {v:.3g} m/s "
                f"at {gait} and {rate:.3g} rad/s, whatever the torque"
                f"{self._needed([state.gait for state in states])}; ask for a wider range of rates "
                "or more torque"
            )
        return NotConverged(
            f"no gait reaches {speed:g} m/s {within} at up to "
            f"{self.cloud.omega_rad_s[-1]:.3g} rad/s; the fastest found"
            f"{'' if self.exact else ' by the exact model'} makes {v:.3g} m/s, at {gait} and "
            f"{rate:.3g} rad/s; ask for less speed, or wider limits"
        )

    def _needed(self, gaits: list[Gait]) -> str:
        """Return in words which limit the gaits break least, and what it would have to be."""
        worst = [min((left, name) for name, left in self.search.margins(g).items()) for g in gaits]
        if not worst or max(worst)[0] >= 0:
            return ""
        short, name = max(worst)
        way = "lower" if name == "omega_low_rad_s" else "higher"
        more = 100 * math.expm1(-short)
        return f"; the nearest of {len(gaits)} needs a {LIMIT_NAMES[name]} {more:.3g} % {way}"


def _numerical(state: Any, cost: str) -> float:
    """Return the error of a state's power: its own, and what the error of the speed is worth."""
    own = getattr(state, f"{cost}_error_w", getattr(state, "power_error_w", 0.0))
    return own + 2 * state.error_estimate * getattr(state, f"{cost}_w")


def finder(
    robot: Robot,
    ground: Ground,
    speeds: Sequence[float],
    cost: str,
    limits: GaitLimits,
    rtol: float | None = None,
    formulation: str = "explicit",
    stiffness: float = 1e3,
    damping: float = 1.0,
) -> Finder:
    """Check what is asked for and return a Finder for it."""
    check_parts(robot, ground)
    for speed in speeds:
        most = _MOST_LENGTHS_A_SECOND * robot.links * robot.link_length_m
        check_number("speed_m_s", speed, 0.0, most, open_low=True)
    check_choice("cost", cost, COSTS)
    check_choice("formulation", formulation, FORMULATIONS)
    springs = formulation == "implicit"
    if rtol is None:
        rtol = (
            1e-4 if springs else 1e-5 if not ground.smooth else 1e-10 if cost == "power" else 1e-8
        )
    check_ground(ground, rtol)

    def soft(gait: Gait, rtol: float) -> Any:
        found = steady_springs(
            robot,
            ground,
            gait,
            joint_stiffness_n_m=stiffness,
            joint_damping_n_s_m=damping,
            rtol=rtol,
        )
        return _Soft(gait, **{k: v for k, v in found.to_dict().items() if k in _Soft.__slots__})

    return Finder(robot, ground, cost, limits, soft if springs else None, speeds, rtol)


@dataclass(frozen=True, slots=True)
class _Soft:
    """A periodic state of the implicit model, with its gait."""

    gait: Gait
    speed_m_s: float
    power_w: float
    abs_power_w: float
    positive_power_w: float
    error_estimate: float
