"""A coarse table of shapes over rates: where to begin the search for any speed."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..base.errors import BadInput
from ..base.long_calls import threads_to_use
from ..model.core_model import core_model
from ..model.gait import Gait
from ..model.ground import Ground
from ..model.robot import Robot
from ..periodic.steady import speed_floor_m_s
from .limits import GaitLimits
from .shapes import COSTS, RATE_STEP, STATES, Array, Point, shape_of

_SWINGS = np.radians(np.geomspace(4.0, 90.0, 14))  # of headings: gaits outside hardly travel
_LAGS = 14, 20  # up to 8 links and for more: long robots have several narrow valleys
_SLOWEST = 2.0  # rate times body length over speed: a wave of the body hardly moves it faster
_AT_ONCE = 3  # rates that are solved together, each from the one before
_BESIDE = 3.0  # times the cheapest of every second shape: what those between may hide
_MOST_RATES = 30  # a factor of a million
_PENALTY = 8.0  # e-folds of cost for an e-fold beyond a limit: a start may lie beyond it
_WITHIN = 1.6  # times the cheapest: what the table's coarseness may hide
_VALLEY = 0.35  # e-folds of shape: starts nearer than that lie in one valley
_STARTS = 6  # valleys that are followed


class GaitTable:
    """Speeds and costs of shapes over rates, as far up as they may matter.

    A shape is followed to higher rates while it costs less than the cheapest gait known that makes
    the speed. So each rate that gives it the speed is known, and none beyond can be cheaper.

    Attributes
    ----------
    alpha_rad, beta_rad : (S,)
        Amplitude and lag of the joints.
    omega_rad_s : (W,)
        Rates.
    speed_m_s, cost_w : (S, W)
        NaN where not solved.
    """

    def __init__(
        self, robot: Robot, ground: Ground, cost: str, limits: GaitLimits, speeds: Sequence[float]
    ) -> None:
        _check_rolling(ground)
        self.robot, self.ground, self.cost, self.limits = robot, ground, cost, limits
        n = robot.links
        lags = np.geomspace(min(math.radians(22), 2.2 / n), math.radians(175), _LAGS[n > 8])
        alpha = 2 * _SWINGS[:, None] * np.sin(lags / 2)
        most = min(limits.joint_angle_rad, math.pi)
        kept = np.vstack([np.ones((1, lags.size), bool), alpha[:-1] < most])  # the limit's own, too
        self.alpha_rad = np.minimum(alpha, most)[kept]
        self.beta_rad = np.broadcast_to(lags, alpha.shape)[kept]
        lowest = min(
            _SLOWEST * min(speeds) / robot.body_length_m,
            limits.omega_high_rad_s / RATE_STEP,
            limits.servo_speed_rad_s / (4 * float(self.alpha_rad.max())),
        )
        self.omega_rad_s = lowest * RATE_STEP ** np.arange(_MOST_RATES)
        self.speed_m_s, self.cost_w = np.full((2, self.alpha_rad.size, _MOST_RATES), np.nan)
        places = np.argwhere(kept)
        coarse = (places % 2 == 0).all(axis=1)
        self._grow(speeds, coarse)
        far = abs(places[:, None] - places[self._promising(speeds)]).max(axis=2, initial=0)
        self._grow(speeds, ~coarse & (far <= 1).any(axis=1))

    def _grow(self, speeds: Sequence[float], useful: NDArray[np.bool_]) -> None:
        """Add some shapes, upwards in rate while each may still be cheaper than what is known."""
        limits = self.limits
        for columns in np.split(np.arange(_MOST_RATES), _MOST_RATES // _AT_ONCE):
            if not useful.any():
                break
            self._solve(columns, useful)
            best = max(np.nanmin(self._roots(v)[1], initial=math.inf) for v in speeds)
            highest = self.omega_rad_s[columns[-1]]
            useful = useful & ~(self.cost_w[:, columns[-1]] > best)
            useful &= self.alpha_rad * highest < RATE_STEP * limits.servo_speed_rad_s
            useful &= highest < limits.omega_high_rad_s

    def _solve(self, columns: NDArray[np.int_], useful: NDArray[np.bool_]) -> None:
        """Solve some shapes at some rates."""
        rates = self.omega_rad_s[columns]
        models = [
            core_model(self.robot, self.ground, Gait(alpha, beta, 1.0))
            for alpha, beta in np.column_stack([self.alpha_rad, self.beta_rad])[useful].tolist()
        ]
        powers, threads = self.cost != "power", threads_to_use()
        rows = _core.sweep(models, rates.tolist(), STATES, powers, threads, None, rough=True)
        v, solved = rows[..., 0], rows[..., 10] > 0.5
        v = np.where(v > STATES * rates * speed_floor_m_s(self.robot, 1.0), v, 1e-300)  # or noise
        cost = rows[..., 1 + COSTS.index(self.cost)]
        place = np.ix_(useful, columns)
        self.speed_m_s[place], self.cost_w[place] = np.where(solved, [v, cost], np.nan)

    @property
    def highest_rate(self) -> float:
        """Return the highest rate that was looked at, rad/s."""
        return self.omega_rad_s[np.isfinite(self.cost_w).any(axis=0)].max(initial=0.0)

    def _promising(self, speeds: Sequence[float]) -> NDArray[np.bool_]:
        """Return which shapes may lie beside the cheapest; all where a speed is not reached."""
        promising = np.zeros(self.alpha_rad.size, bool)
        for v in speeds:
            price = self._roots(v)[1]
            best = np.nanmin(price, initial=math.inf)
            promising |= (price <= _BESIDE * best).any(axis=1) | (best == math.inf)
        return promising

    def _roots(self, speed_m_s: float) -> tuple[Array, Array]:
        """Return rate and price of every root of every shape at a speed, (S, W - 1).

        The price is the cost, dearer beyond a limit. NaN where there is no root.
        """
        x, limits = np.log(self.omega_rad_s), self.limits
        with np.errstate(all="ignore"):
            y, cost = np.log(self.speed_m_s / speed_m_s), np.log(self.cost_w)
            part = y[:, :-1] / (y[:, :-1] - y[:, 1:])
            rate = np.exp(x[:-1] + part * np.diff(x))
            used = np.maximum(self.alpha_rad[:, None] * rate / limits.servo_speed_rad_s, 1.0)
            used = np.maximum(used, limits.omega_low_rad_s / rate)
            used = np.maximum(used, rate / limits.omega_high_rad_s)
            price = np.exp(cost[:, :-1] + part * np.diff(cost)) * used**_PENALTY
            return rate, np.where(y[:, :-1] * y[:, 1:] <= 0, price, np.nan)

    def starts(self, speed_m_s: float, apart: float = _VALLEY, count: int = _STARTS) -> list[Point]:
        """Return the cheapest shapes at a speed, so far from each other, cheapest first."""
        rate, price = self._roots(speed_m_s)
        kept: list[Point] = []
        most = _WITHIN * np.nanmin(price, initial=math.inf)
        for place in np.argsort(price, axis=None)[: np.count_nonzero(price <= most)]:
            k, root = np.unravel_index(place, price.shape)
            alpha, beta = float(self.alpha_rad[k]), float(self.beta_rad[k])
            shape = shape_of(alpha, beta)
            if all(math.dist(shape, other.shape) > apart for other in kept):
                gait = Gait(alpha, beta, float(rate[k, root]))
                kept.append(Point(shape, gait, math.log(price[k, root])))
        return kept[:count]

    def fastest(self) -> tuple[float, float, float, float]:
        """Return speed, alpha, beta and rate of the fastest gait of the table within the limits."""
        best, limits, x = (0.0, 0.0, 0.0, 0.0), self.limits, np.log(self.omega_rad_s)
        for alpha, beta, v in zip(self.alpha_rad, self.beta_rad, self.speed_m_s, strict=True):
            top = math.log(min(limits.servo_speed_rad_s / alpha, limits.omega_high_rad_s, 1e300))
            known = np.isfinite(v)
            if known.any():
                rates = np.minimum(x[known], top)
                speeds = np.exp(np.interp(rates, x[known], np.log(v[known])))
                k = int(speeds.argmax())
                best = max(best, (float(speeds[k]), float(alpha), float(beta), math.exp(rates[k])))
        return best


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
