"""The rates at which shapes of gait have one wanted speed on viscous ground, found by the core."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..model.core_model import core_model
from ..model.gait import Gait
from ..model.ground import Ground
from ..model.robot import Robot
from .steady import MAX_ELEMENTS

Array = NDArray[np.float64]
COSTS = ("power", "abs_power", "positive_power")  # mean powers that a search makes least
_SPREAD = 0.1  # e-folds of rate: so far off may a guess be
_FASTEST = 1e300  # rad/s, in place of no limit


class SpeedState(NamedTuple):
    """Hold the state of a shape at the rate that gives a speed: rad, rad/s, m/s, W.

    error_estimate: of the speed, relative. slopes: of ln rate, ln power_w, ln abs_power_w and
    ln positive_power_w, against ln speed.
    """

    alpha_rad: float
    beta_rad: float
    omega_rad_s: float
    speed_m_s: float
    power_w: float
    abs_power_w: float
    positive_power_w: float
    error_estimate: float
    slopes: tuple[float, ...]

    @property
    def gait(self) -> Gait:
        """Return the gait."""
        return Gait(self.alpha_rad, self.beta_rad, self.omega_rad_s)


class LowestShape(NamedTuple):
    """Hold the lowest cost's swing and lag, its state, and the shapes solved for it.

    gap: e-folds of cost, what the last model misses. tangent: of swing, lag and ln rate, against
    ln speed. state: None where the lowest point is at a bound, or a shape has no state.
    """

    shapes: int
    shape: tuple[float, float] = (0.0, 0.0)
    gap: float = np.inf
    tangent: Array | None = None
    state: SpeedState | None = None


class SpeedSolver:
    """Solves shapes of gait on one viscous ground for speeds; cost: as `least_power_gait` has."""

    def __init__(self, robot: Robot, ground: Ground, cost: str) -> None:
        self._model = core_model(robot, ground, Gait(1.0, 1.0, 1.0))
        self._cost, self._powers = COSTS.index(cost), cost != "power"

    def solve(
        self,
        alpha_rad: Array,
        beta_rad: Array,
        guess: float,
        speed_m_s: float,
        highest: float,
        rtol: float,
    ) -> list[SpeedState | None]:
        """Return a state for each shape, or None where no rate near the guess gives the speed.

        guess, highest: rates, rad/s; shapes whose amplitude is none, or beyond pi, have no state.
        """
        count = alpha_rad.size
        found = _core.at_speed(
            self._model,
            alpha_rad.tolist(),
            beta_rad.tolist(),
            [guess] * count,
            [_SPREAD] * count,
            speed_m_s,
            min(highest, _FASTEST),
            rtol,
            self._powers,
            MAX_ELEMENTS,
        )
        shapes = zip(alpha_rad.tolist(), beta_rad.tolist(), found.tolist(), strict=True)
        return [None if row[0] != row[0] else _state(a, b, speed_m_s, row) for a, b, row in shapes]

    def lowest(
        self,
        start: tuple[float, float, float, float, float],
        bounds: tuple[Array, Array],
        speed_m_s: float,
        highest: float,
        rtol: float,
    ) -> LowestShape:
        """Return the shape of least cost in the valley of a start.

        start: swing, lag, ln rate; half of the first and of the last box. bounds: of swing and lag.
        """
        low, high = (bound.tolist() for bound in bounds)
        shapes, *found = _core.lowest_shape(
            self._model,
            start,
            low,
            high,
            self._cost,
            speed_m_s,
            min(highest, _FASTEST),
            rtol,
            self._powers,
            MAX_ELEMENTS,
        )
        if not found:
            return LowestShape(shapes)
        swing, lag, gap, tangent, row = found
        beta = float(np.exp(lag))
        state = _state(float(2 * np.exp(swing) * np.sin(beta / 2)), beta, speed_m_s, row)
        moves = np.array(tangent) if np.isfinite(tangent).all() else None
        return LowestShape(shapes, (swing, lag), gap, moves, state)


def _state(alpha_rad: float, beta_rad: float, speed_m_s: float, row: list[float]) -> SpeedState:
    rate, net, absolute, positive, error, *slopes = row
    return SpeedState(
        alpha_rad, beta_rad, rate, speed_m_s, net, absolute, positive, error, tuple(slopes)
    )
