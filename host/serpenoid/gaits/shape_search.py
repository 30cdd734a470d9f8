"""One shape of gait: the rate that gives it a wanted speed, and its cost there."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from ..model.errors import NotConverged, SerpenoidError
from ..model.gait import Gait
from ..model.ground import Ground
from ..model.robot import Robot
from ..periodic.at_speed import SpeedSolver, SpeedState
from ..periodic.near_states import LocalFit, NearState, solve_near
from ..periodic.steady import steady_gait
from .limits import GaitLimits, peak_torque_nm
from .quadratic_search import Array, Point, Valley

Solve = Callable[[Gait, float], Any]  # a gait, an accuracy -> .speed_m_s, .power_w ...
_MOST_STEPS = 40  # secants; usual are 4 to 6
_FAR, _FAR_DRY = 9.0, 4.0  # e-folds of rate from the guess; a dry table's guess is near
_LARGEST_STEP = 1.1  # e-folds of rate: a factor of 3
_STEP_BLIND = 0.7  # e-folds, where the slope of speed against rate says nothing
_LEAST_SLOPE = 0.1  # of ln speed against ln rate; it is 1 where inertia counts for little
_CLOSE, _VERY_CLOSE = 0.01, 1e-3  # e-folds of speed: a miss that slopes, or a guess, put right
_SOLVED = 2e-4  # the same for a shape that was chosen
_STEEP, _STEEPEST_COST = 0.3, 4.0  # slopes of ln speed, and of ln cost over it, that are trusted
_TELLS_SLOPES = 0.003  # e-folds of rate: two states this far apart give slopes
_ASIDE = 0.03  # e-folds of rate: a second state, where no slopes are known
_BACK = 0.04  # e-folds of rate: back from where wheels begin to slide and speed falls
_ENOUGH = 12  # shapes known at a speed, in place of those known at another
_DEAR = 0.7  # e-folds of cost above the least: such ends may lie beyond a fold, none starts there
_KNOWN = 0.2  # e-folds of shape: farther ones tell too little to start from
_NEAR_MISS = 30  # times the accuracy asked for: a state this good still ranks shapes


class GaitShape(NamedTuple):
    """Hold alpha and beta in the coordinates of the search.

    swing: ln of the amplitude of the links' headings, alpha / (2 sin(beta / 2)); it matters more
    than the amplitude of the joints. lag: ln beta.
    """

    swing: float
    lag: float

    @classmethod
    def of(cls, alpha_rad: float, beta_rad: float) -> GaitShape:
        """Return the shape with this amplitude and lag of the joints."""
        return cls(math.log(alpha_rad / (2 * math.sin(beta_rad / 2))), math.log(beta_rad))

    @property
    def alpha_rad(self) -> float:
        """Return the amplitude of the joints."""
        return 2 * math.exp(self.swing) * math.sin(self.beta_rad / 2)

    @property
    def beta_rad(self) -> float:
        """Return the lag from joint to joint."""
        return min(math.exp(self.lag), math.pi)


class Candidate(NamedTuple):
    """Hold a shape, the rate that should give the speed, and its cost in W."""

    watts: float
    shape: GaitShape
    omega_rad_s: float


def exact_solver(robot: Robot, ground: Ground, powers: bool) -> Solve:
    """Return a function that solves a gait by the exact model; it accepts a near miss."""

    def solve(gait: Gait, rtol: float) -> Any:
        try:
            return steady_gait(robot, ground, gait, rtol=rtol, powers=powers)
        except NotConverged as error:
            best = getattr(error, "best", None)
            if best is None or not best.error_estimate <= _NEAR_MISS * rtol:
                raise
            return best

    return solve


class ShapeSearch:
    """Cost of a shape at one speed; the rate follows from the speed."""

    def __init__(
        self, robot: Robot, ground: Ground, solve: Solve, cost: str, limits: GaitLimits
    ) -> None:
        self.robot, self.ground, self.solve, self.cost = robot, ground, solve, cost
        self.limits = limits
        self.evaluations = 0

    def at_speed(self, shape: GaitShape, speed_m_s: float, guess: float, rtol: float) -> Any | None:
        """Return the state of a shape at the rate that gives the speed, or None if none does.

        Secants on log speed against log rate, kept to steps of a factor of 3.
        """
        if not 0 < shape.alpha_rad <= math.pi:
            return None
        x, last = math.log(guess), None
        far = _FAR if self.ground.smooth else _FAR_DRY
        high = min(math.log(min(self.limits.omega_high_rad_s, 1e300)) + _STEP_BLIND, x + far)
        for _ in range(_MOST_STEPS):
            try:
                state = self.solve(Gait(shape.alpha_rad, shape.beta_rad, math.exp(x)), rtol)
            except SerpenoidError:
                return None
            self.evaluations += 1
            y = math.log(max(state.speed_m_s, 1e-300) / speed_m_s)
            slope = 1.0
            if last is not None and x != last[0]:
                slope = (y - last[1]) / (x - last[0])
            if abs(y) <= 2 * rtol:
                return state
            step = -y / slope if slope > _LEAST_SLOPE else -math.copysign(_STEP_BLIND, y)
            last = (x, y)
            x += min(max(step, -_LARGEST_STEP), _LARGEST_STEP)
            if not math.log(guess) - far <= x <= high:
                return None
        return None

    def torque_nm(self, gait: Gait) -> float:
        """Return the gait's peak torque where there is a limit to it, else 0."""
        if self.limits.servo_torque_nm == math.inf:
            return 0.0
        return peak_torque_nm(self.robot, self.ground, gait)

    def margins(self, gait: Gait) -> dict[str, float]:
        """Return by how many e-folds a gait is below each limit."""
        return self.limits.margins(gait, self.torque_nm(gait))

    def watts(self, state: Any) -> float:
        """Return the cost of a state, W."""
        return getattr(state, f"{self.cost}_w")

    def point(self, at: Array, speed_m_s: float, guess: float, rtol: float) -> Point:
        """Return ln of the cost at a shape, and its least margin to a limit."""
        state = self.at_speed(GaitShape(*at), speed_m_s, guess, rtol)
        if state is None:
            return Point(at, math.inf, -1.0)
        margin = min(self.margins(state.gait).values(), default=math.inf)
        # power goes as speed squared: this takes out the remaining error of the speed
        value = math.log(max(self.watts(state), 1e-300)) - 2 * math.log(state.speed_m_s / speed_m_s)
        return Point(at, value, margin, state)

    def points(
        self, shapes: Sequence[Array], speed_m_s: float, guess: float, rtol: float
    ) -> list[Point]:
        """Return many points; guess: the rate, about."""
        return on_threads(lambda at: self.point(at, speed_m_s, guess, rtol), shapes)

    def bounds(self) -> tuple[Array, Array]:
        """Return the least and greatest coordinates that are searched."""
        n = self.robot.links
        low = np.array([math.log(math.radians(1.0)), math.log(min(0.08, 0.8 / n))])
        return low, np.array([math.log(math.radians(150.0)), math.log(math.pi)])


class SmoothShapes(ShapeSearch):
    """Costs of shapes on viscous ground, many in one call of the core.

    tangent: the change of the last lowest point's swing, lag and ln rate with ln speed, or None.
    """

    def __init__(
        self, robot: Robot, ground: Ground, solve: Solve, cost: str, limits: GaitLimits
    ) -> None:
        super().__init__(robot, ground, solve, cost, limits)
        self._solver = SpeedSolver(robot, ground, cost)

    def points(
        self, shapes: Sequence[Array], speed_m_s: float, guess: float, rtol: float
    ) -> list[Point]:
        """Return many points; guess: the rate, about."""
        beta = np.minimum(np.exp([at[1] for at in shapes]), math.pi)
        alpha = 2 * np.exp([at[0] for at in shapes]) * np.sin(beta / 2)
        highest = self.limits.omega_high_rad_s
        states = self._solver.solve(alpha, beta, guess, speed_m_s, highest, rtol)
        self.evaluations += len(states)
        return [self._point(*both) for both in zip(shapes, states, strict=True)]

    def _point(self, at: Array, state: SpeedState | None) -> Point:
        if state is None:
            return Point(at, math.inf, -1.0)
        torque = self.torque_nm(state.gait) if self.limits.servo_torque_nm < math.inf else 0.0
        left = self.limits.left(state.alpha_rad, state.alpha_rad, state.omega_rad_s, torque)
        value = math.log(max(self.watts(state), 1e-300))
        return Point(at, value, min(left.values(), default=math.inf), state)

    def lowest(
        self, start: Candidate, radius: float, smallest: float, speed_m_s: float, rtol: float
    ) -> Valley | None:
        """Return the lowest point of a start's valley, or None where it is not clear of limits."""
        found = self._solver.lowest(
            (start.shape.swing, start.shape.lag, math.log(start.omega_rad_s), radius, smallest),
            self.bounds(),
            speed_m_s,
            self.limits.omega_high_rad_s,
            rtol,
        )
        self.evaluations += found.shapes
        if found.state is None:
            return None
        end = self._point(np.array(found.shape), found.state)
        return Valley(end, found.gap, found.tangent) if end.margin > smallest else None


class NearShapes(ShapeSearch):
    """Costs of shapes on dry ground at one speed, many at a time, each from what is known beside.

    Fits to the shapes known so far expect rate and state of a new one. Mostly one state is enough:
    what its speed misses is put right by the slopes.
    """

    def __init__(
        self, robot: Robot, ground: Ground, solve: Solve, cost: str, limits: GaitLimits
    ) -> None:
        super().__init__(robot, ground, solve, cost, limits)
        self._speed_m_s, self._least = math.nan, math.inf
        self._known, self._before = LocalFit(2, 6), LocalFit(2, 6)

    def points(
        self, shapes: Sequence[Array], speed_m_s: float, guess: float, rtol: float
    ) -> list[Point]:
        """Return many points, solved together; guess: the rate where nothing is known near."""
        return self.rated(shapes, speed_m_s, [guess] * len(shapes), rtol)

    def rated(
        self,
        shapes: Sequence[Array],
        speed_m_s: float,
        guesses: Sequence[float],
        rtol: float,
        close: float = _CLOSE,
        rough: bool = True,
    ) -> list[Point]:
        """Return many points; guesses: a rate for each shape, for where nothing is known near.

        close: e-folds of speed that slopes put right; rough: states of one level.
        """
        if speed_m_s != self._speed_m_s:
            self._to_speed(speed_m_s)
        at = np.array(shapes)
        known = self._best_known()
        near = [known.nearest(one) < _KNOWN for one in at]
        expected = known.expect(at) if any(near) else np.empty((len(at), 6))
        highest = math.log(min(self.limits.omega_high_rad_s, 1e300)) + _STEP_BLIND
        ways = [
            _WayToSpeed(one, math.log(guess), row if told else None, highest, close)
            for one, guess, row, told in zip(at, guesses, expected, near, strict=True)
        ]
        for _ in range(_MOST_STEPS):
            going = [way for way in ways if way.goes_on]
            if not going:
                break
            for begun in (True, False):
                self._step([way for way in going if (way.start is not None) == begun], rtol, rough)
        ended = [way for way in ways if way.state is not None]
        self._least = min([self._least, *(way.at_speed[1] for way in ended)])
        ended = [way for way in ended if way.at_speed[1] <= self._least + _DEAR]
        if ended:
            self._known.add(
                np.array([way.at for way in ended]), np.array([way.told() for way in ended])
            )
        return [self._end(way) for way in ways]

    def _best_known(self) -> LocalFit:
        few = len(self._known.at) < min(_ENOUGH, len(self._before.at))
        return self._before if few else self._known

    def _to_speed(self, speed_m_s: float) -> None:
        """Go on to another speed: what is known starts it, its rates changed by their slopes."""
        known = self._best_known()
        self._before, self._known, self._least = LocalFit(2, 6), LocalFit(2, 6), math.inf
        if len(known.at):
            rows = known.values.copy()
            rows[:, 0] += math.log(speed_m_s / self._speed_m_s) / np.maximum(rows[:, 4], _STEEP)
            self._before.add(known.at, rows)
        self._speed_m_s = speed_m_s

    def solved(self, point: Point, speed_m_s: float, rtol: float) -> Point:
        """Return a point again, its speed hardly missed: slopes from afar may have been wrong."""
        state: Any = point.data
        rates = [state.gait.omega_rad_s]
        return self.rated([point.at], speed_m_s, rates, rtol, _SOLVED, rough=False)[0]

    def _step(self, ways: list[_WayToSpeed], rtol: float, rough: bool) -> None:
        """Solve the next state of every way; all of them have a start or none has."""
        if not ways:
            return
        gaits = [Gait(*way.angles, math.exp(way.x)) for way in ways]
        starts = [way.start for way in ways if way.start is not None]
        found = solve_near(
            self.robot,
            self.ground,
            gaits,
            starts or None,
            rtol,
            self.cost != "power",
            rough=rough,
        )
        self.evaluations += len(ways)
        for way, state in zip(ways, found, strict=True):
            way.go(state, self._speed_m_s, 0.0 if state is None else self.watts(state))

    def _end(self, way: _WayToSpeed) -> Point:
        if way.state is None:
            return Point(way.at, math.inf, -1.0)
        gait = replace(way.state.gait, omega_rad_s=math.exp(way.at_speed[0]))
        state = way.state._replace(gait=gait, speed_m_s=self._speed_m_s)
        margin = min(self.margins(gait).values(), default=math.inf)
        return Point(way.at, way.at_speed[1], margin, state)


class _WayToSpeed:
    """A shape's way to the rate that gives a speed: secants on logarithms, from what is expected.

    known: ln rate, start over the rate (3), slopes of ln speed and ln cost against ln rate.
    """

    def __init__(
        self, at: Array, x: float, known: Array | None, highest: float, close: float
    ) -> None:
        shape = GaitShape(*at.tolist())
        self.at, self.angles = at, (shape.alpha_rad, shape.beta_rad)
        self.x, self.start, self.slopes = x, None, None
        if known is not None:
            self.x, self.start, self.slopes = float(known[0]), known[1:4], known[4:]
        self.low, self.high = self.x - _FAR_DRY, min(highest, self.x + _FAR_DRY)
        self.goes_on = 0 < shape.alpha_rad <= math.pi
        self.state: NearState | None = None
        self.at_speed = (0.0, 0.0)  # ln rate and ln cost
        self._last: tuple[float, float, float] | None = None
        self._nearest: tuple[float, float, float, NearState] | None = None
        self._steps, self._close, self._turned, self._expected = 0, close, False, self.slopes

    def go(self, state: NearState | None, speed_m_s: float, watts: float) -> None:
        """Take the state at the last rate: set the next rate, or the end."""
        self._steps += 1
        if state is None:
            self.goes_on = False
            return
        y = math.log(max(state.speed_m_s, 1e-300) / speed_m_s)
        cost, last = math.log(max(watts, 1e-300)), self._last
        if last is not None and abs(self.x - last[0]) >= _TELLS_SLOPES:
            self.slopes = np.array([y - last[1], cost - last[2]]) / (self.x - last[0])
        self._last, self.start = (self.x, y, cost), state.start
        if abs(y) <= self._close and (self._nearest is None or abs(y) < abs(self._nearest[1])):
            self._nearest = (self.x, y, cost, state)
        if self._nearest is not None and self._ends(*self._nearest):
            return
        if abs(y) <= self._close and self.slopes is None:
            self.x += _ASIDE
            return
        if self._beyond_the_fastest(y):
            return
        slope = 1.0 if self.slopes is None else float(self.slopes[0])
        step = -y / slope if slope > _LEAST_SLOPE else -math.copysign(_STEP_BLIND, y)
        self.x += min(max(step, -_LARGEST_STEP), _LARGEST_STEP)
        self.goes_on = self.low <= self.x <= self.high and self._steps < _MOST_STEPS

    def _beyond_the_fastest(self, y: float) -> bool:
        """Turn back, once, where more rate gives less speed: below there may be rate enough."""
        if y >= 0 or self._turned or self.slopes is None or self.slopes[0] > _LEAST_SLOPE:
            return False
        self._turned, self.slopes, self._last = True, self._expected, None
        self.x -= _BACK
        return True

    def _ends(self, x: float, y: float, cost: float, state: NearState) -> bool:
        """End at a state if its speed is right, or so near that trusted slopes put it right."""
        if self.slopes is not None and self._trusted(*self.slopes.tolist()):
            slope, power = self.slopes.tolist()
        elif abs(y) <= _VERY_CLOSE and self.slopes is not None:
            slope, power = 1.0, 2.0
        else:
            return False
        self.state, self.goes_on, self.start = state, False, state.start
        self.at_speed = (x - y / slope, cost - y / slope * power)
        return True

    @staticmethod
    def _trusted(slope: float, power: float) -> bool:
        return slope >= _STEEP and 0 <= power <= _STEEPEST_COST * slope

    def told(self) -> Array:
        """Return what the way's end tells of its shape, as in `known`."""
        assert self.start is not None
        assert self.slopes is not None
        return np.array([self.at_speed[0], *self.start, *self.slopes])


def on_threads(work: Callable[[Any], Any], items: Iterable[Any]) -> list[Any]:
    """Return work(item) for every item, in order; the core lets go of Python's lock."""
    with ThreadPoolExecutor() as pool:
        return list(pool.map(work, items))
