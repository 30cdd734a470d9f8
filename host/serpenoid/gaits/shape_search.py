"""One shape of gait: the rate that gives it a wanted speed, and its cost there."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any, NamedTuple

import numpy as np

from ..model.errors import NotConverged, SerpenoidError
from ..model.gait import Gait
from ..model.ground import Ground
from ..model.robot import Robot
from ..periodic.steady import steady_gait
from .limits import GaitLimits, peak_torque_nm
from .quadratic_search import Array, Point

Solve = Callable[[Gait, float], Any]  # a gait, an accuracy -> .speed_m_s, .power_w ...
_MOST_STEPS = 40  # secants; usual are 4 to 6
_FAR, _FAR_DRY = 9.0, 4.0  # e-folds of rate from the guess; a dry table's guess is near
_LARGEST_STEP = 1.1  # e-folds of rate: a factor of 3
_STEP_BLIND = 0.7  # e-folds, where the slope of speed against rate says nothing
_LEAST_SLOPE = 0.1  # of ln speed against ln rate; it is 1 where inertia counts for little
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
            if abs(y) <= 2 * rtol:
                return state
            slope = 1.0 if last is None or x == last[0] else (y - last[1]) / (x - last[0])
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
        """Return many points, on two threads or as many as there are processors."""
        return on_threads(lambda at: self.point(at, speed_m_s, guess, rtol), shapes)

    def bounds(self) -> tuple[Array, Array]:
        """Return the least and greatest coordinates that are searched."""
        n = self.robot.links
        low = np.array([math.log(math.radians(1.0)), math.log(min(0.08, 0.8 / n))])
        return low, np.array([math.log(math.radians(150.0)), math.log(math.pi)])


def on_threads(work: Callable[[Any], Any], items: Iterable[Any]) -> list[Any]:
    """Return work(item) for every item, in order; the core lets go of Python's lock."""
    with ThreadPoolExecutor() as pool:
        return list(pool.map(work, items))
