"""A coarse cloud of gaits over all shapes and rates, for ranking shapes at any speed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..model.ground import Ground
from ..model.robot import Robot
from ..periodic.sweep import sweep
from .limits import GaitLimits
from .shape_search import GaitShape, on_threads

Array = NDArray[np.float64]
# Rates that are tried, as omega times body length over speed; then further up while that may help.
_FIRST, _STEP, _MANY = 4.0, 1.9, 6
_FIRST_DRY, _STEP_DRY, _MANY_DRY = 6.0, 1.9, 4  # a dry gait costs a hundred times as much
_FURTHER = 4  # rates, for slow and cheap shapes alone
_BEYOND = 2.0  # of the servos' speed: gaits so far beyond it are still looked at
_STILL = 1e-6  # of body length times rate: a speed below it is the solver's noise, not a gait's
_SWING_DEG = (5, 9, 14, 20, 27, 35, 44, 54, 66, 80)
_SWING_DRY_DEG = (6, 11, 17, 24, 31, 38, 46, 55, 66, 80)


class Candidate(NamedTuple):
    """Hold a shape of the cloud, the rate that should give the speed, and what it should cost."""

    watts: float
    shape: GaitShape
    omega_rad_s: float


def interpolated(omega_rad_s: Array, v: Array, p: Array, speed_m_s: float) -> tuple[Array, Array]:
    """Return rate and cost at a speed, (S, L), from speeds v and costs p, (S, L, W); else NaN.

    Straight lines in log-log between the two rates that enclose the speed.
    """
    x = np.log(omega_rad_s)
    rate, watts = np.full(v.shape[:2], np.nan), np.full(v.shape[:2], np.nan)
    with np.errstate(divide="ignore", invalid="ignore"):
        y, q = np.log(v / speed_m_s), np.log(p)
    for k in range(x.size - 2, -1, -1):  # the lowest rate that serves overwrites
        here = (y[:, :, k] <= 0) & (y[:, :, k + 1] >= 0) & np.isfinite(q[:, :, k])
        with np.errstate(divide="ignore", invalid="ignore"):
            f = np.clip(-y[:, :, k] / (y[:, :, k + 1] - y[:, :, k]), 0, 1)
            f = np.where(np.isfinite(f), f, 1.0)
        rate = np.where(here, np.exp(x[k] + f * (x[k + 1] - x[k])), rate)
        watts = np.where(here, np.exp(q[:, :, k] + f * (q[:, :, k + 1] - q[:, :, k])), watts)
    return rate, watts


def valleys(price: Array, most: int) -> list[tuple[float, list[int]]]:
    """Return price and place of what no neighbour undercuts, cheapest first; inf: no price."""
    padded = np.pad(price, 1, constant_values=np.inf)
    around = [
        padded[1 + i : 1 + i + price.shape[0], 1 + j : 1 + j + price.shape[1]]
        for i in (-1, 0, 1) for j in (-1, 0, 1) if i or j
    ]  # fmt: skip
    local = np.isfinite(price) & (price <= np.min(around, axis=0))
    return sorted(zip(price[local].tolist(), np.argwhere(local).tolist(), strict=True))[:most]


class GaitCloud:
    """Speeds and costs over shapes and rates; shapes span every gait that travels.

    alpha_rad, beta_rad: (S, L) over amplitude of heading and lag; omega_rad_s: (W,);
    speed_m_s, cost_w: (S, L, W), NaN where there is no solution.
    """

    def __init__(
        self, robot: Robot, ground: Ground, cost: str, limits: GaitLimits, speeds: Sequence[float]
    ) -> None:
        self.robot, self.ground, self.cost, self.limits = robot, ground, cost, limits
        n = robot.links
        first, step, many = (
            (_FIRST, _STEP, _MANY) if ground.smooth else (_FIRST_DRY, _STEP_DRY, _MANY_DRY)
        )
        least_lag = min(math.radians(22), 2.2 / n)  # a third of a wave on the body
        lags = np.geomspace(least_lag, math.radians(165), 12 if n <= 8 else 18)
        swings = np.radians(np.array(_SWING_DEG if ground.smooth else _SWING_DRY_DEG, dtype=float))
        self.beta_rad = np.broadcast_to(lags, (swings.size, lags.size))
        self.alpha_rad = 2 * swings[:, None] * np.sin(lags / 2)
        self.omega_rad_s = np.empty(0)
        self.speed_m_s = self.cost_w = np.empty((swings.size, lags.size, 0))
        base = 1 / (n * robot.link_length_m)
        span = math.log(max(speeds) / min(speeds)) / math.log(step)
        factors = np.array([step**k for k in range(many + math.ceil(span))])
        self._extend(max(base * min(speeds) * first, limits.omega_low_rad_s) * factors)
        self._reach_up(max(speeds))
        if not ground.smooth:
            self._go_on(speeds, step)

    def _go_on(self, speeds: Sequence[float], step: float) -> None:
        """Try higher rates with the shapes that are slow still, but cost less than the cheapest."""
        for _ in range(_FURTHER):
            top = float(self.omega_rad_s[-1])
            slow = np.zeros(self.alpha_rad.shape, dtype=bool)
            for speed in speeds:
                best = np.nanmin(self.at_speed(speed)[1], initial=math.inf)
                slow |= (self.speed_m_s[:, :, -1] < speed) & (self.cost_w[:, :, -1] < best)
            if top >= self.limits.omega_high_rad_s or not slow.any():
                return
            self._extend(np.array([step * top]), slow)

    def _extend(self, rates: Array, shapes: NDArray[np.bool_] | None = None) -> None:
        """Solve all shapes, or some, at more rates."""
        top, n = self.limits.omega_high_rad_s, self.robot.links
        rates = np.unique(np.minimum(rates, top))
        allowed = self.alpha_rad <= min(self.limits.joint_angle_rad, math.pi)
        if shapes is not None:
            allowed &= shapes
        shape = (*self.alpha_rad.shape, rates.size)
        speed, cost = np.full(shape, np.nan), np.full(shape, np.nan)

        def column(j: int) -> None:
            rows = np.flatnonzero(allowed[:, j])
            if rows.size == 0:
                return
            least = float(self.alpha_rad[rows, j].min())
            many = int(np.searchsorted(rates, _BEYOND * self.limits.servo_speed_rad_s / least))
            if many == 0:
                return
            found = sweep(
                self.robot, self.ground, alpha_rad=self.alpha_rad[rows, j],
                beta_rad=self.beta_rad[0, j], omega_rad_s=rates[:many],
                rtol=1e-4 if self.ground.smooth else 3e-3, powers=self.cost != "power",
            )  # fmt: skip
            good = found.converged[:, 0]
            v = found.speed_m_s[:, 0]
            v = np.where(v > _STILL * rates[:many] * n * self.robot.link_length_m, v, 0.0)
            speed[rows, j, :many] = np.where(good, v, np.nan)
            cost[rows, j, :many] = np.where(good, getattr(found, f"{self.cost}_w")[:, 0], np.nan)

        on_threads(column, range(self.alpha_rad.shape[1]))
        self.omega_rad_s = np.concatenate([self.omega_rad_s, rates])
        self.speed_m_s = np.concatenate([self.speed_m_s, speed], axis=2)
        self.cost_w = np.concatenate([self.cost_w, cost], axis=2)

    def _reach_up(self, speed_m_s: float) -> None:
        """Add higher rates while none of the shapes reaches the speed, to a million of lengths."""
        for _ in range(5):
            top = self.omega_rad_s[-1]
            if np.nanmax(self.speed_m_s, initial=0) >= speed_m_s:
                return
            if top >= self.limits.omega_high_rad_s:
                return
            if top * self.alpha_rad.min() > _BEYOND * self.limits.servo_speed_rad_s:
                return
            self._extend(top * 3.0 ** np.arange(1, 4))

    def at_speed(self, speed_m_s: float) -> tuple[Array, Array]:
        """Return rate and cost of every shape at a speed, (S, L); NaN where none gives it.

        Straight lines in log-log between the two rates that enclose the speed.
        """
        rate, watts = interpolated(self.omega_rad_s, self.speed_m_s, self.cost_w, speed_m_s)
        return self._below(speed_m_s, rate, watts)

    def _below(self, speed_m_s: float, rate: Array, watts: Array) -> tuple[Array, Array]:
        """Fill in shapes too fast at the lowest rate: speed as the rate, cost as its square."""
        with np.errstate(divide="ignore", invalid="ignore"):
            f = speed_m_s / self.speed_m_s[:, :, 0]
            fast = (f < 1) & np.isnan(rate)
            rate = np.where(fast, f * self.omega_rad_s[0], rate)
            return rate, np.where(fast, f**2 * self.cost_w[:, :, 0], watts)

    def candidates(self, speed_m_s: float, most: int, within: float) -> list[Candidate]:
        """Return the cheapest shapes that no neighbour undercuts, at most `within` times the best.

        Limits of servo speed and rate are kept; where no shape keeps them, those nearest to it.
        """
        rate, watts = self.at_speed(speed_m_s)
        with np.errstate(invalid="ignore", divide="ignore"):
            over = np.maximum(
                np.log(self.alpha_rad * rate / self.limits.servo_speed_rad_s),
                np.log(self.limits.omega_low_rad_s / rate),
            )
        price = np.where(np.isnan(watts), np.inf, watts * np.exp(8 * np.maximum(over, 0)))
        picked = valleys(price, most)
        return [
            Candidate(
                cost, GaitShape.of(self.alpha_rad[i, j], self.beta_rad[i, j]), float(rate[i, j])
            )
            for cost, (i, j) in picked
            if cost <= within * picked[0][0]
        ]

    def cheapest_shapes(self, speed_m_s: float, within: float) -> list[Candidate]:
        """Return all shapes that cost at most `within` times the best, cheapest first."""
        rate, watts = self.at_speed(speed_m_s)
        good = np.argwhere(watts <= within * np.nanmin(watts, initial=math.inf)).tolist()
        return sorted(
            Candidate(
                float(watts[i, j]), GaitShape.of(self.alpha_rad[i, j], self.beta_rad[i, j]),
                float(rate[i, j]),
            )
            for i, j in good
        )  # fmt: skip

    def fastest(self) -> tuple[float, float, float, float]:
        """Return speed, alpha, beta and rate of the fastest gait found within the limits."""
        return max(self._fastest_of_cloud(), self._fastest_servos())

    def _fastest_servos(self) -> tuple[float, float, float, float]:
        """Return the fastest gait of shapes at the rate that the servos' speed allows, or less."""
        best = (0.0, 0.0, 0.0, 0.0)
        if self.limits.servo_speed_rad_s == math.inf:
            return best
        small = self.alpha_rad[:1] * np.array([[0.2], [0.4], [0.6], [0.8]])
        for j, beta in enumerate(self.beta_rad[0].tolist()):
            for alpha in np.concatenate([small[:, j], self.alpha_rad[:, j]]).tolist():
                top = min(self.limits.servo_speed_rad_s / alpha, self.limits.omega_high_rad_s)
                rates = np.array([0.25, 0.5, 1.0]) * top
                if alpha > min(self.limits.joint_angle_rad, math.pi):
                    continue
                found = sweep(
                    self.robot, self.ground, alpha_rad=alpha, beta_rad=beta, omega_rad_s=rates,
                    rtol=1e-3, powers=False, threads=1,
                )  # fmt: skip
                v = np.where(found.converged, found.speed_m_s, 0.0)[0, 0]
                k = int(v.argmax())
                best = max(best, (float(v[k]), alpha, beta, float(rates[k])))
        return best

    def _fastest_of_cloud(self) -> tuple[float, float, float, float]:
        rate = np.broadcast_to(self.omega_rad_s, self.speed_m_s.shape)
        allowed = self.alpha_rad[:, :, None] * rate <= self.limits.servo_speed_rad_s * 1.0000001
        v = np.where(allowed & np.isfinite(self.speed_m_s), self.speed_m_s, 0.0)
        i, j, k = np.unravel_index(int(np.argmax(v)), v.shape)
        return v[i, j, k], self.alpha_rad[i, j], self.beta_rad[i, j], rate[i, j, k]
