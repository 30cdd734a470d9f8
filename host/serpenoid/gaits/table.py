"""A coarse table of shapes over rates: where to begin the search for any speed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..model.core_model import core_model
from ..model.errors import BadInput
from ..model.gait import Gait
from ..model.ground import Ground
from ..model.robot import Robot
from ..periodic.grid import threads_to_use
from .limits import GaitLimits
from .shapes import COSTS, Candidate, GaitShape

Array = NDArray[np.float64]
_SWINGS = np.radians(np.geomspace(4.0, 90.0, 14))  # of headings: gaits outside hardly travel
_LAGS = 14, 20  # up to 8 links and for more: long robots have several narrow valleys
_RTOL = 3e-3  # of speeds; a table ranks shapes, and lines between its rates err by more
_RATE_STEP = 1.6  # from rate to rate: log-log lines between them err by a few per cent
_SLOWEST = 2.0  # rate times body length over speed: a wave of the body hardly moves it faster
_FIRST_RATES = 4  # solved for every shape: more at a time are cheaper
_MOST_RATES = 30  # steps up at most, a factor of a million in rate
_PENALTY = 8.0  # a limit exceeded by a factor f costs f^8, so starts within limits come first
_STILL = 1e-6  # of body length times rate: a lower speed is noise of the solver


class GaitTable:
    """Speeds and costs of shapes over rates, as far up as they may matter.

    A shape is followed to higher rates while it costs less than the cheapest gait known that makes
    the speed. So each rate that gives it the speed is known, and none beyond can be cheaper.

    Parameters
    ----------
    robot, ground, cost, limits
        As in `least_power_gait`.
    speeds
        Those of interest, m/s.

    Attributes
    ----------
    alpha_rad, beta_rad : (S, L)
        Amplitude and lag of the joints.
    omega_rad_s : (W,)
        Rates.
    speed_m_s, cost_w : (S, L, W)
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
        beyond = np.vstack([np.zeros((1, lags.size), bool), alpha[:-1] >= most])
        self.alpha_rad = np.where(beyond, np.nan, np.minimum(alpha, most))  # the limit's own, too
        self.beta_rad = np.broadcast_to(lags, alpha.shape)
        self.omega_rad_s = np.empty(0)
        self.speed_m_s = self.cost_w = np.empty((*alpha.shape, 0))
        self._grow(speeds)

    def _grow(self, speeds: Sequence[float]) -> None:
        """Add rates upwards while a shape may still be cheaper than what is known."""
        limits, body = self.limits, self.robot.body_length_m
        lowest = max(_SLOWEST * min(speeds) / body, limits.omega_low_rad_s / _RATE_STEP)
        lowest = min(lowest, limits.omega_high_rad_s / _RATE_STEP)
        lowest = min(lowest, limits.servo_speed_rad_s / (4 * float(np.nanmax(self.alpha_rad))))
        useful = np.isfinite(self.alpha_rad)
        count = _FIRST_RATES
        while useful.any() and self.omega_rad_s.size < _MOST_RATES:
            rates = lowest * _RATE_STEP ** (self.omega_rad_s.size + np.arange(count))
            rates = rates[rates < limits.omega_high_rad_s * _RATE_STEP * 1.01]
            if not rates.size:
                return
            self._add(rates, useful)
            best = max(np.nanmin(self._prices(v)[1], initial=math.inf) for v in speeds)
            useful &= ~(self.cost_w[:, :, -1] > best)
            useful &= self.alpha_rad * rates[-1] < _RATE_STEP * limits.servo_speed_rad_s
            count = 2

    def _add(self, rates: NDArray[Any], useful: NDArray[np.bool_]) -> None:
        """Solve some shapes at some rates."""
        alpha, beta = self.alpha_rad[useful].tolist(), self.beta_rad[useful].tolist()
        models = [
            core_model(self.robot, self.ground, Gait(a, b, 1.0))
            for a, b in zip(alpha, beta, strict=True)
        ]
        powers, threads = self.cost != "power", min(threads_to_use(None), len(models))
        rows = _core.sweep(models, rates.tolist(), _RTOL, powers, threads, None, rough=True)
        v, good = rows[..., 0], rows[..., 10] > 0.5
        v = np.where(v > _STILL * rates * self.robot.body_length_m, v, 1e-300)
        speed, cost = np.full((2, *useful.shape, rates.size), np.nan)
        speed[useful] = np.where(good, v, np.nan)
        cost[useful] = np.where(good, rows[..., 1 + COSTS.index(self.cost)], np.nan)
        self.omega_rad_s = np.append(self.omega_rad_s, rates)
        self.speed_m_s = np.concatenate([self.speed_m_s, speed], axis=2)
        self.cost_w = np.concatenate([self.cost_w, cost], axis=2)

    def _prices(self, speed_m_s: float) -> tuple[Array, Array]:
        """Return rate and price of every root of every shape at a speed, (S, L, W - 1).

        The price is the cost, dearer beyond a limit. NaN where there is no root.
        """
        x = np.log(self.omega_rad_s)
        with np.errstate(all="ignore"):
            y, q = np.log(self.speed_m_s / speed_m_s), np.log(self.cost_w)
            part = y[:, :, :-1] / (y[:, :, :-1] - y[:, :, 1:])
            rate = np.exp(x[:-1] + part * np.diff(x))
            watts = np.exp(q[:, :, :-1] + part * np.diff(q, axis=2))
            none = ~(y[:, :, :-1] * y[:, :, 1:] <= 0)
            excess = np.log(self._used(rate)).clip(0, 30)
            return rate, np.where(none, np.nan, watts * np.exp(_PENALTY * excess))

    def _used(self, rate: Array) -> Array:
        """Return by what factor gaits are nearest to a limit, or beyond it."""
        limits = self.limits
        return np.maximum.reduce(
            [
                self.alpha_rad[:, :, None] * rate / limits.servo_speed_rad_s,
                limits.omega_low_rad_s / rate,
                rate / limits.omega_high_rad_s,
            ]
        )

    def starts(self, speed_m_s: float, within: float) -> list[Candidate]:
        """Return roots of shapes that cost at most `within` times the cheapest, cheapest first."""
        rate, price = self._prices(speed_m_s)
        found = np.argwhere(price <= within * np.nanmin(price, initial=math.inf)).tolist()
        return sorted(
            Candidate(
                float(price[i, j, k]),
                GaitShape.of(float(self.alpha_rad[i, j]), float(self.beta_rad[i, j])),
                float(rate[i, j, k]),
            )
            for i, j, k in found
        )

    def fastest(self) -> tuple[float, float, float, float]:
        """Return speed, alpha, beta and rate of the fastest gait of the table within the limits."""
        best, limits, x = (0.0, 0.0, 0.0, 0.0), self.limits, np.log(self.omega_rad_s)
        for place in zip(*np.nonzero(np.isfinite(self.speed_m_s[:, :, 0])), strict=True):
            alpha, beta = self.alpha_rad[place], self.beta_rad[place]
            known = np.isfinite(self.speed_m_s[place])
            top = math.log(min(limits.servo_speed_rad_s / alpha, limits.omega_high_rad_s, 1e300))
            rates = np.minimum(x[known], top)
            v = np.interp(rates, x[known], np.log(self.speed_m_s[place][known]))
            k = int(v.argmax())
            best = max(best, (math.exp(v[k]), float(alpha), float(beta), math.exp(rates[k])))
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
