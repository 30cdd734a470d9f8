"""One shape of gait at a wanted speed: the rate that gives it, what it costs, and its limits."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..model.core_model import core_model
from ..model.errors import NotConverged
from ..model.gait import Gait
from ..model.ground import Ground
from ..model.robot import Robot
from ..periodic.steady import from_core, steady_gait
from .limits import GaitLimits, peak_torque_nm

Array = NDArray[np.float64]
Solve = Callable[[Gait, float], Any]  # a gait, an accuracy -> .speed_m_s, .power_w ... or None
COSTS = ("power", "abs_power", "positive_power")  # mean powers that a search makes least
_ROUGH = 1e-3
_NEAR_MISS = 30  # times the accuracy asked for: a state this good still ranks shapes
_PENALTY = 60.0  # e-folds of cost for one beyond a limit: cost falls less beyond any
ROUNDING = 5e-5  # e-folds beyond a limit, at most, that count as on it
_SECANTS = 10  # usual are 2 to 4; more mean that they lead nowhere
_EXTREME = 50.0  # ln rate: no robot turns so fast or slowly
_LONGEST = 0.7  # e-folds of rate: a secant that goes farther, a factor of 2, knows too little
_LEAST_SLOPE = 0.1  # of ln speed against ln rate: below, the speed hardly rises with the rate
_ASIDE = 0.01  # e-folds of rate between two states at least, so that their slope means something
_WALK = 0.12  # e-folds of rate: roots that lie closer together than this are not told apart
_WALKS = 12  # steps down at most, a factor of 4 in rate: a table's guess is nearer


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


class Accuracy(NamedTuple):
    """State the relative accuracy of states, and by how much of ln speed a search may miss."""

    rtol: float
    miss: float


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
            return best if best is not None and best.error_estimate <= _NEAR_MISS * rtol else None

    def rough(gait: Gait, rtol: float) -> Any:
        model = core_model(robot, ground, gait)
        (state,) = _core.neighbours(
            model, [model], rtol, powers, 1, rough=True, starts=[(0.0, 0.0, 0.0)]
        )
        return from_core(robot, ground, gait, state) if state.converged else None

    return lambda gait, rtol: (rough if rtol >= _ROUGH else solve)(gait, rtol)


@dataclass(frozen=True)
class Point:
    """Hold a shape's gait at the wanted speed: ln of its cost, its least margin to a limit.

    gait: None where no rate gives the speed.
    """

    at: Array
    gait: Gait | None = None
    value: float = math.inf
    margin: float = -1.0

    def faster(self, factor: float) -> Point:
        """Return where to begin the search for so many times the speed."""
        assert self.gait is not None
        return replace(self, gait=replace(self.gait, omega_rad_s=factor * self.gait.omega_rad_s))

    @property
    def allowed(self) -> bool:
        """Tell whether there is a gait that keeps the limits."""
        return self.margin >= 0

    @property
    def price(self) -> float:
        """Return what a search makes least: beyond a limit more than the cost."""
        return self.value - _PENALTY * min(self.margin, 0.0)

    @property
    def better(self) -> tuple[bool, float]:
        """Return the key that orders points: allowed ones first."""
        return (not self.allowed, self.price)


class Shapes:
    """Costs of shapes at a speed; `evaluations` counts the states solved."""

    def __init__(
        self, robot: Robot, ground: Ground, solve: Solve, cost: str, limits: GaitLimits
    ) -> None:
        self.robot, self.ground, self.solve, self.cost = robot, ground, solve, cost
        self.limits, self.evaluations = limits, 0

    def solved_by(self, solve: Solve) -> Shapes:
        """Return the same with another solver."""
        return Shapes(self.robot, self.ground, solve, self.cost, self.limits)

    def watts(self, state: Any) -> float:
        """Return the cost of a state, W."""
        return getattr(state, f"{self.cost}_w")

    def torque_nm(self, gait: Gait) -> float:
        """Return the gait's peak torque where there is a limit to it, else 0."""
        if self.limits.servo_torque_nm == math.inf:
            return 0.0
        return peak_torque_nm(self.robot, self.ground, gait)

    def margins(self, gait: Gait) -> dict[str, float]:
        """Return by how many e-folds a gait is below each limit."""
        return self.limits.margins(gait, self.torque_nm(gait))

    def bounds(self) -> tuple[Array, Array]:
        """Return the least and greatest coordinates that are searched."""
        least_lag = min(0.08, 0.8 / self.robot.links)
        low = np.array([math.log(math.radians(1.0)), math.log(least_lag)])
        return low, np.array([math.log(math.radians(150.0)), math.log(math.pi)])

    def point(self, at: Array, speed_m_s: float, rate: float, how: Accuracy) -> Point:
        """Return a shape at the rate near a guess that gives the speed."""
        shape = GaitShape(*at)
        if not 0 < shape.alpha_rad <= math.pi:
            return Point(at)
        angles = self._within(shape.alpha_rad), shape.beta_rad
        end = _WayToSpeed(self, angles, speed_m_s, how).end(math.log(rate))
        if end is None:
            return Point(at)
        gait = Gait(*angles, math.exp(end[0]))
        # rounding of the rate is no violation of a limit
        margin = min(self.margins(gait).values(), default=math.inf) + min(3 * how.rtol, ROUNDING)
        return Point(at, gait, end[1], margin)

    def _within(self, alpha_rad: float) -> float:
        """Return an amplitude, or the greatest allowed where it is beyond that by rounding."""
        most = self.limits.joint_angle_rad
        return most if most < alpha_rad <= most * (1 + ROUNDING) else alpha_rad


class _WayToSpeed:
    """The way to the rate at which a shape makes a speed, on logarithms."""

    def __init__(
        self, shapes: Shapes, angles: tuple[float, float], speed_m_s: float, how: Accuracy
    ) -> None:
        self._shapes, self._angles, self._speed_m_s, self._how = shapes, angles, speed_m_s, how
        self._known: dict[
            float, tuple[float, float]
        ] = {}  # ln rate -> ln speed over wanted, ln cost

    def end(self, guess: float) -> tuple[float, float] | None:
        """Return ln rate and ln cost at the speed: by secants or, where they fail, between rates.

        A line between the last two states puts a small miss right.
        """
        x = last = guess
        for _ in range(_SECANTS):
            y = self.miss(x)
            slope = 1.0 if x == last else (y - self.miss(last)) / (x - last)
            if math.isnan(y) or not slope > _LEAST_SLOPE:
                break
            if abs(y) <= self._how.miss and x != last:
                return self._between(x, last)
            step = min(max(-y / slope, -_LONGEST), _LONGEST)
            if abs(x + step) > _EXTREME:
                return None
            if abs(step) < _ASIDE and x == last:
                step = math.copysign(_ASIDE, step)
            x, last = x + step, x
        ends = self._enclosed()
        if ends is None:
            return None
        low, high = ends
        while high - low > self._how.miss / 4:
            x = (low + high) / 2
            y = self.miss(x)
            if math.isnan(y):
                return None
            low, high = (low, x) if y * self.miss(low) <= 0 else (x, high)
        jumps = abs(self.miss(low) - self.miss(high)) > 20 * self._how.miss
        return None if jumps else self._between(low, high)  # no rate of a jump gives the speed

    def miss(self, x: float) -> float:
        """Return ln of the speed over the wanted one at ln rate x; NaN without a state."""
        if x not in self._known:
            shapes, y, cost = self._shapes, math.nan, math.nan
            shapes.evaluations += 1
            state = shapes.solve(Gait(*self._angles, math.exp(x)), self._how.rtol)
            if state is not None:
                y = math.log(max(state.speed_m_s, 1e-300) / self._speed_m_s)
                cost = math.log(max(shapes.watts(state), 1e-300))
            self._known[x] = y, cost
        return self._known[x][0]

    def _between(self, x: float, last: float) -> tuple[float, float]:
        (y, q), (y0, q0) = self._known[x], self._known[last]
        part = y / (y - y0) if y != y0 else 0.0
        return x + part * (last - x), q + part * (q0 - q)

    def _enclosed(self) -> tuple[float, float] | None:
        """Return the lowest two ln rates known that enclose one that gives the speed, or None.

        Where speed does not rise with the rate, a rate that gives the speed is below, or none is.
        """
        rates = sorted(x for x, (y, _) in self._known.items() if not math.isnan(y))
        for low, high in pairwise(rates):
            if self.miss(low) * self.miss(high) <= 0:
                return low, high
        for k in range(_WALKS if rates else 0):
            x, last = rates[0] - (k + 1) * _WALK, rates[0] - k * _WALK
            y, before = self.miss(x), self.miss(last)
            if y * before <= 0:
                return x, last
            if not (y > 0 or y > before):
                return None
        return None


def on_threads(work: Callable[[Any], Any], items: Iterable[Any]) -> list[Any]:
    """Return work(item) for every item, in order; the core lets go of Python's lock."""
    with ThreadPoolExecutor() as pool:
        return list(pool.map(work, items))
