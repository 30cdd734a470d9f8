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
from ..model.errors import BadInput, NotConverged
from ..model.gait import Gait
from ..model.ground import Ground
from ..model.robot import Robot
from ..periodic.steady import Steady, check_ground
from ..simulation.steady_springs import steady_springs
from .fixed_rate import FixedRateSearch
from .gait_cloud import GaitCloud
from .gait_table import Candidate, refined_valleys
from .limits import LIMIT_NAMES, GaitLimits
from .quadratic_search import Point, minimize
from .shape_search import GaitShape, ShapeSearch, Solve, exact_solver

COSTS = ("power", "abs_power", "positive_power")
ANY = GaitLimits()
_MOST_LENGTHS_A_SECOND = 1e4  # a faster wish makes no sense, and the cloud's rates would not end
_VALLEYS = 6  # of the cloud, followed at most
_WITHIN, _WITHIN_DRY = 1.4, 1.6  # of the cheapest: what the cloud's coarseness may hide
_RADIUS, _RADIUS_KNOWN = 0.15, 0.08  # first box: half a step of the cloud; round a known gait
_NARROW = 1.2  # ratio of rates: a narrower range is searched at fixed rates
_APART = 0.1  # e-folds of shape: two ends closer than this are one valley
_CLOSER = 4.0  # refinement factor for the best valley on dry ground
_WIDTHS = (0.25, 0.08, 0.025, 0.008)  # e-folds either way, of its tables of shapes
_SMALL_VALLEYS = 3  # followed of each table
_ROUNDING = 1e-9  # body lengths x rate: a slower gait travels by rounding errors alone
_AT_LIMIT = 2e-6  # e-folds of shape: last box beside a limit, on viscous ground
_LIMITS_WORTH = 2.0  # e-folds of cost at most, for one of a limit
_DRY_GAP = 2e-3  # e-folds: small dry valleys were found so far apart, so no optimum is known better


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
        Power of the second best valley, W; inf if there was one valley.
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
        self, robot: Robot, ground: Ground, cost: str, limits: GaitLimits, solve: Solve | None,
        speeds: Sequence[float], rtol: float,
    ) -> None:  # fmt: skip
        self.robot, self.ground, self.limits, self.rtol = robot, ground, limits, rtol
        self.exact = solve is None
        solver = solve or exact_solver(robot, ground, powers=cost != "power")
        self.search = ShapeSearch(robot, ground, solver, cost, limits)
        self.cloud = GaitCloud(robot, ground, cost, limits, speeds)
        self.coarse = 1e-7 if ground.smooth and self.exact else 3e-4  # accuracy of the search
        self.least_gap = self.coarse if ground.smooth else _DRY_GAP
        self.smallest = 0.002 if ground.smooth and self.exact else 0.012

    def follow(
        self, start: Candidate, speed: float, radius: float, closer: float = 1.0
    ) -> tuple[Point, float]:
        """Return the lowest point of a candidate's valley; closer: refinement factor."""
        low, high = self.search.bounds()
        rtol = max(self.rtol, self.coarse / closer)
        evaluate = partial(self.search.points, speed_m_s=speed, guess=start.omega_rad_s, rtol=rtol)
        first = evaluate([np.array(start.shape)])[0]
        end, gap = minimize(evaluate, first, radius, self.smallest / closer, low, high)
        if self.exact and self.ground.smooth and 0 <= end.margin < self.smallest:
            # along a limit the cost is no valley: it rises with the distance from the limit
            end, gap = minimize(evaluate, end, self.smallest, _AT_LIMIT, low, high)
            gap = max(gap, _LIMITS_WORTH * max(end.margin, 0.0))
        return end, gap

    def candidates(self, speed: float) -> list[Candidate]:
        """Return the cloud's valleys that may hold the minimum."""
        return self.cloud.candidates(
            speed, _VALLEYS, _WITHIN if self.ground.smooth else _WITHIN_DRY
        )

    def minimize(self, speed: float, extra: Candidate | None = None) -> LeastPower:
        """Return the cheapest gait; extra: one more start."""
        starts = self.candidates(speed) + ([extra] if extra else [])
        followed = [self.follow(s, speed, _RADIUS_KNOWN if s is extra else _RADIUS) for s in starts]
        ends = [end for end in followed if not end[0].better[0]] or self.at_fixed_rates(speed)
        if not ends:
            raise self.unreachable(speed, [point for point, _ in followed])
        ends.sort(key=lambda e: e[0].value)
        if not self.ground.smooth:
            ends[0] = self.refined(ends[0][0], speed)
        return self.finish(speed, ends)

    def at_fixed_rates(self, speed: float) -> list[tuple[Point, float]]:
        """Return the cheapest gaits at the ends and the middle of a narrow range of rates."""
        low, high = self.limits.omega_low_rad_s, self.limits.omega_high_rad_s
        if not 0 < high <= _NARROW * low:
            return []
        rates = np.unique([low, math.sqrt(low * high), high])
        searches = [FixedRateSearch(self.search, float(rate), speed) for rate in rates]
        found = [search.minimize(self.rtol, self.coarse) for search in searches]
        return [end for end in found if end is not None]

    def refined(self, best: Point, speed: float) -> tuple[Point, float]:
        """Return the best of a dry valley, where kinks make small valleys in the large one.

        Finer and finer tables of shapes show them, and the best are followed. The last table's
        gain, or what it saw below, may still be missing. The finest table is for steep valleys.
        """
        gap = 0.0
        for width in _WIDTHS:
            state: Any = best.data
            starts = refined_valleys(self.search, state.gait, speed, width, _SMALL_VALLEYS)
            before = best.value
            for start in starts:
                point, _ = self.follow(start, speed, width / 6, closer=_CLOSER)
                best = min(best, point, key=lambda p: p.better)
            gap = max(before - best.value, 0.0)
            if self.exact and starts:  # the tables are the exact model's
                gap = max(gap, best.value - math.log(starts[0].watts))
            if width == _WIDTHS[-2] and gap <= self.least_gap:
                break
        return best, gap

    def finish(self, speed: float, ends: list[tuple[Point, float]]) -> LeastPower:
        """Solve the best once more, to the accuracy that was asked for."""
        (best, gap), search = ends[0], self.search
        rough: Any = best.data
        state = (
            search.at_speed(GaitShape(*best.at), speed, rough.gait.omega_rad_s, self.rtol) or rough
        )
        watts = search.watts(state)
        apart = [p for p, _ in ends[1:] if np.abs(p.at - best.at).max() > _APART]
        exact, own = self.exact_state(state), _numerical(state, search.cost)
        gap = max(gap, self.least_gap) + 3 * abs(
            state.speed_m_s / speed - 1
        )  # power goes as speed^2
        return LeastPower(
            state.gait, watts, state.speed_m_s, search.cost, exact, limits=self.limits,
            active=self.limits.active(state.gait, search.torque_nm(state.gait)),
            power_error_w=own + watts * min(gap, 1.0), solved_error_w=own,
            basins=1 + len(apart), evaluations=search.evaluations,
            runner_up_w=watts * math.exp(apart[0].value - best.value) if apart else math.inf,
        )  # fmt: skip

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
    robot: Robot, ground: Ground, speeds: Sequence[float], cost: str, limits: GaitLimits,
    rtol: float | None = None, formulation: str = "explicit", stiffness: float = 1e3,
    damping: float = 1.0,
) -> Finder:  # fmt: skip
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
    _check_rolling(ground)

    def soft(gait: Gait, rtol: float) -> Any:
        found = steady_springs(
            robot, ground, gait, joint_stiffness_n_m=stiffness, joint_damping_n_s_m=damping,
            rtol=rtol,
        )  # fmt: skip
        return _Soft(gait, **{k: v for k, v in found.to_dict().items() if k in _Soft.__slots__})

    return Finder(robot, ground, cost, limits, soft if springs else None, speeds, rtol)


def _check_rolling(ground: Ground) -> None:
    """Refuse wheels without rolling friction that grip dryly: no gait has the least power.

    They follow the wave as a train follows its rails, at omega link_length_m / beta however small
    alpha is, and no friction does any work.
    """
    if ground.ct_forward == ground.ft0_forward == 0.0 < ground.fn0:
        raise BadInput(
            "ct and ft0 are both 0: the wheels roll for nothing, and fn0 holds them sideways. The "
            "less the joints bend, the less power it takes, so no gait takes least; give the "
            "measured ct or ft0, even if it is small"
        )


@dataclass(frozen=True, slots=True)
class _Soft:
    """A periodic state of the implicit model, with its gait."""

    gait: Gait
    speed_m_s: float
    power_w: float
    abs_power_w: float
    positive_power_w: float
    error_estimate: float
