"""The search for the gait of least power at a speed: from a table down its valleys, then closer."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.optimize import minimize, minimize_scalar

from ..model.checks import FORMULATIONS, check_choice, check_number
from ..model.core_model import check_parts
from ..model.errors import NotConverged, SerpenoidError
from ..model.gait import Gait
from ..model.ground import Ground
from ..model.robot import Robot
from ..periodic.steady import Steady, check_ground, steady_gait
from ..simulation.steady_springs import steady_springs
from .limits import LIMIT_NAMES, GaitLimits
from .shapes import COSTS, ROUNDING, Accuracy, Array, Candidate, Point, Shapes, Solve, exact_solver
from .table import GaitTable

ANY = GaitLimits()
_MOST_LENGTHS_A_SECOND = 1e4  # a faster wish makes no sense
_WITHIN = 1.6  # times the cheapest of the table: what its coarseness may hide
_APART = 0.35  # e-folds of shape: starts nearer than that lie in one valley
_STARTS = 6  # valleys followed at most
_FIRST, _CLOSER = 0.15, 0.08  # e-folds of shape: first simplex of a table's start, and closer
_TURN = np.array([[1, 1], [-1, 1]]) / math.sqrt(2)
_SIMPLEX = np.array([[0, 0], [1, 0], [0, 1]])
_SIDES = np.array([[1, 0], [-1, 0], [0, 1], [0, -1]])
_DOUBT = 0.02  # e-folds of cost: ends this near to the lowest are searched closer
_ROUNDS, _GAINED = 4, 3e-4  # closer descents repeat while they gain more, e-folds of cost
_NEAR_LIMIT = 0.03  # e-folds: so near to a limit its own curve is searched
_DRY_GAP = 1e-3  # e-folds of cost: what kinks smaller than the last box hide on dry ground
_FAR_ALONG = 0.8  # of a stretch of a limit: an end so far out asks for the next stretch
_STRETCHES = 6  # of a limit at most: its curve may leave the range of shapes
_BESIDE = 1e-3  # e-folds of shape, for slopes of a margin
_ONTO = 8  # secants onto a limit; usual are 2
_HOPELESS = 1e3  # price of a shape without a gait
_SAME_VALLEY = 0.1  # e-folds of shape between ends


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


class Finder:
    """Finds the cheapest gaits of one robot on one ground, for any speed, from one table."""

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
        self.shapes = Shapes(robot, ground, solver, cost, limits)
        self.table = GaitTable(robot, ground, cost, limits, speeds)
        self.rough, self.fine = Accuracy(1e-3, 3e-3), Accuracy(1e-4, 1e-4)
        self.steps, self.least_gap = (0.02, 2e-3), _DRY_GAP
        if self.exact and ground.smooth:
            self.rough, self.fine = Accuracy(1e-5, 1e-3), Accuracy(1e-9, 1e-5)
            self.steps, self.least_gap = (0.01, 1e-4), 1e-7

    def starts(self, speed: float) -> list[Candidate]:
        """Return the cheapest shapes of the table, far enough from each other."""
        kept: list[Candidate] = []
        for one in self.table.starts(speed, _WITHIN):
            if all(math.dist(one.shape, other.shape) > _APART for other in kept):
                kept.append(one)
        return kept[:_STARTS]

    def descend(
        self, speed: float, start: Point | Candidate, size: float, fine: bool = False
    ) -> Point:
        """Return the lowest point of a valley, also along the limits that it reaches.

        size: of the first simplex, e-folds of shape; below 0 it looks the other way.
        """
        valley = _Valley(self.shapes, speed, start, self.fine if fine else self.rough)
        how = {
            "initial_simplex": valley.start + size * _SIMPLEX,
            "xatol": self.steps[fine],
            "fatol": valley.how.miss / 10,
            "maxfev": 90,
        }
        minimize(valley.price, valley.start, method="Nelder-Mead", options=how)
        end = valley.best
        if end.gait is not None:
            for name, margin in self.shapes.margins(end.gait).items():
                if margin < _NEAR_LIMIT:
                    valley.along(name, end, abs(size))
        return min(valley.points, key=_better)

    def ends(self, speed: float, starts: Sequence[Point | Candidate]) -> list[Point]:
        """Return the lowest points of the starts' valleys, cheapest first; the lowest closer."""
        found = sorted([self.descend(speed, one, _FIRST) for one in starts], key=_better)
        kept = []
        for end in found:
            if all(math.dist(end.at, other.at) > _SAME_VALLEY for other in kept):
                kept.append(end)
        closer = [
            self.descend(speed, end, _CLOSER / 2, fine=True)
            if end.value < kept[0].value + _DOUBT
            else end
            for end in kept
        ]
        return sorted(closer, key=_better)

    def closest(self, speed: float, best: Point) -> tuple[Point, float]:
        """Return the end of closer descents from and around the best, and what the last gained."""
        end, gain, radius, sides = best, math.inf, _CLOSER, _SIDES
        for turn in range(_ROUNDS):
            before, starts = end, [end]
            if self.ground.dry:  # kinks make small valleys in a large one
                around = [replace(end, at=end.at + radius * side) for side in sides]
                rough = [self.descend(speed, start, -radius / 2) for start in around]
                starts.append(min(rough, key=_better))  # whose value is not held against fine ones
            fine = [self.descend(speed, start, -radius / 4, fine=True) for start in starts]
            end = min([end, *fine], key=_better)
            gain = before.value - end.value
            if gain < _GAINED and (turn or self.ground.smooth):
                break
            radius, sides = radius / 2 if turn == 0 else radius, sides @ _TURN
        return end, gain

    def front(self, speeds: Sequence[float]) -> list[LeastPower | NotConverged]:
        """Return the cheapest gait of each speed, in ascending order, or why there is none.

        Each is searched from the table, then from the gait of the slower and of the faster speed.
        """
        ends = [self.ends(speed, self.starts(speed)) for speed in speeds]
        upwards = [(k, k + 1) for k in range(len(speeds) - 1)]
        for known, k in [*upwards, *((k, known) for known, k in reversed(upwards))]:
            if ends[known] and ends[known][0].allowed:
                start = ends[known][0].faster(speeds[k] / speeds[known])
                ends[k] = sorted([*self.ends(speeds[k], [start]), *ends[k]], key=_better)
        return [self._best(speed, valleys) for speed, valleys in zip(speeds, ends, strict=True)]

    def _best(self, speed: float, ends: list[Point]) -> LeastPower | NotConverged:
        """Return the lowest of some valleys, searched more closely, or why there is none."""
        allowed = [end for end in ends if end.allowed]
        if not allowed:
            return self.unreachable(speed, ends)
        best, gain = self.closest(speed, allowed[0])
        return self.finish(speed, best, gain, allowed[1:])

    def finish(self, speed: float, best: Point, gain: float, others: list[Point]) -> LeastPower:
        """Solve the best once more, to the accuracy that was asked for."""
        shapes, how = self.shapes, Accuracy(self.rtol, self.rtol)
        assert best.gait is not None
        gait = shapes.point(best.at, speed, best.gait.omega_rad_s, how).gait or best.gait
        state = shapes.solve(gait, self.rtol)
        watts = shapes.watts(state)
        apart = [p for p in others if math.dist(p.at, best.at) > _SAME_VALLEY]
        solved = _numerical(state, shapes.cost)
        # power goes as speed squared
        gap = max(gain, self.least_gap) + 3 * abs(state.speed_m_s / speed - 1)
        return LeastPower(
            state.gait,
            watts,
            state.speed_m_s,
            shapes.cost,
            self.exact_state(state),
            "explicit" if self.exact else "implicit",
            limits=self.limits,
            active=self.limits.active(state.gait, shapes.torque_nm(state.gait)),
            power_error_w=solved + watts * min(gap, 1.0),
            solved_error_w=solved,
            basins=1 + len(apart),
            evaluations=shapes.evaluations,
            runner_up_w=watts * math.exp(apart[0].value - best.value) if apart else math.inf,
        )

    def exact_state(self, state: Any) -> Steady:
        """Return the exact model's state of a gait with all powers, which a search leaves out."""
        if self.exact and self.shapes.cost != "power":
            return state
        rtol = max(self.rtol, 1e-8) if self.exact else 1e-6
        return steady_gait(self.robot, self.ground, state.gait, rtol=rtol)

    def unreachable(self, speed: float, tried: list[Point]) -> NotConverged:
        """Return the error that says how fast the robot can go, or what the speed would need."""
        v, alpha, beta, rate = self.table.fastest()
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
            f"{self.table.omega_rad_s[-1]:.3g} rad/s; the fastest found"
            f"{'' if self.exact else ' by the exact model'} makes {v:.3g} m/s, at {gait} and "
            f"{rate:.3g} rad/s; ask for less speed, or wider limits"
        )

    def _needed(self, gaits: list[Gait]) -> str:
        """Return in words which limit the gaits break least, and what it would have to be."""
        worst = [min((left, name) for name, left in self.shapes.margins(g).items()) for g in gaits]
        if not worst or max(worst)[0] >= 0:
            return ""
        short, name = max(worst)
        way = "lower" if name == "omega_low_rad_s" else "higher"
        more = 100 * math.expm1(-short)
        return f"; the nearest of {len(gaits)} needs a {LIMIT_NAMES[name]} {more:.3g} % {way}"


def _better(point: Point) -> tuple[bool, float]:
    return point.better


class _Valley:
    """One descent: the points looked at, and the rates that they tell of others."""

    def __init__(
        self, shapes: Shapes, speed_m_s: float, start: Point | Candidate, how: Accuracy
    ) -> None:
        self._shapes, self._speed_m_s, self.how = shapes, speed_m_s, how
        if isinstance(start, Candidate):
            self.start, rate = np.array(start.shape), start.omega_rad_s
        else:
            assert start.gait is not None
            self.start, rate = start.at, start.gait.omega_rad_s
        self._rate = rate
        self.points: list[Point] = []

    @property
    def best(self) -> Point:
        """Return the point of the lowest price."""
        return min(self.points, key=lambda point: point.price)

    def point(self, at: Array) -> Point:
        """Return the point of a shape."""
        at = np.clip(at, *self._shapes.bounds())
        self.points.append(self._shapes.point(at, self._speed_m_s, self._expected(at), self.how))
        return self.points[-1]

    def price(self, at: Array) -> float:
        """Return the price of a shape, which a search makes least."""
        return min(self.point(at).price, _HOPELESS)

    def _expected(self, at: Array) -> float:
        """Return the rate expected at a shape: a linear fit to the points, near ones most."""
        known = [
            (p.at, math.log(p.gait.omega_rad_s)) for p in self.points[-12:] if p.gait is not None
        ]
        if not known:
            return self._rate
        off = np.array([place for place, _ in known]) - at
        logs = np.array([rate for _, rate in known])
        weight = 1 / (np.hypot(*off.T) + 1e-3)
        terms = weight[:, None] * np.column_stack([np.ones(len(off)), off])
        fit = np.linalg.lstsq(terms, weight * logs, rcond=1e-3)[0][0]
        return math.exp(min(max(fit, logs.min() - 0.3), logs.max() + 0.3))

    def along(self, name: str, start: Point, radius: float) -> None:
        """Look along the curve of shapes where a limit is just reached, near a start.

        Along the limit's tangent; each point is put onto the limit along its normal.
        """

        def margin(point: Point) -> float:
            return math.nan if point.gait is None else self._shapes.margins(point.gait)[name]

        beside = [self.point(start.at + _BESIDE * axis) for axis in np.eye(2)]
        slopes = np.array([margin(point) - margin(start) for point in beside]) / _BESIDE
        steep = float(np.hypot(*slopes))
        if not 0 < steep < math.inf:
            return
        normal = slopes / steep
        tangent = np.array([-normal[1], normal[0]])

        def onto(t: float) -> float:
            u, slope = -margin(start) / steep, steep
            point = self.point(start.at + t * tangent + u * normal)
            for _ in range(_ONTO):
                short = margin(point)
                if not (
                    abs(short) > min(self.how.rtol, ROUNDING / 2) and abs(u) < _FIRST and slope
                ):
                    break
                before, u = u, u - short / slope
                point = self.point(start.at + t * tangent + u * normal)
                slope = (margin(point) - short) / (u - before)
            return min(point.price, _HOPELESS)

        t, before = 0.0, math.inf
        for _ in range(_STRETCHES):
            if abs(t - before) <= _FAR_ALONG * radius:
                break
            before = t
            how = {"xatol": self.how.rtol**0.5}
            bounds = (before - radius, before + radius)
            found: Any = minimize_scalar(onto, bounds=bounds, method="bounded", options=how)
            t = float(found.x)


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

    def soft(gait: Gait, rtol: float) -> _Soft | None:
        springs = {"joint_stiffness_n_m": stiffness, "joint_damping_n_s_m": damping}
        try:
            found = steady_springs(robot, ground, gait, rtol=rtol, **springs).to_dict()
        except SerpenoidError:
            return None
        return _Soft(gait, **{k: v for k, v in found.items() if k in _Soft.__slots__})

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
