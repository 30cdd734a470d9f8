"""Least power at a speed by brute force: grids over shapes and rates, ever smaller; no search.

Nothing here is shared with the search but the solver of one gait: all rates that give a shape the
speed are looked at, a shape that breaks a limit is left out, and what is cheapest is solved again.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
import serpenoid as sn
from numpy.typing import NDArray
from serpenoid.gaits.limits import peak_torque_nm

Array = NDArray[np.float64]
Table = Callable[[float, float, Array], tuple[Array, Array]]  # alpha, beta, rates: speeds, watts


def exact_table(robot: sn.Robot, ground: sn.Ground, cost: str, rtol: float) -> Table:
    """Return a function that solves a shape at many rates by the exact model."""

    def table(alpha: float, beta: float, rates: Array) -> tuple[Array, Array]:
        found = sn.sweep(
            robot,
            ground,
            alpha_rad=alpha,
            beta_rad=beta,
            omega_rad_s=rates,
            rtol=rtol,
            powers=cost != "power",
            threads=1,
        )
        good = found.error_estimate[0, 0] < 30 * rtol
        watts = getattr(found, f"{cost}_w")[0, 0]
        return np.where(good, found.speed_m_s[0, 0], np.nan), np.where(good, watts, np.nan)

    return table


@dataclass(frozen=True)
class Found:
    """Hold a shape in ln of heading's amplitude and ln of lag, its rate, and what it costs, W."""

    watts: float
    swing: float
    lag: float
    rate: float

    @property
    def gait(self) -> sn.Gait:
        beta = math.exp(self.lag)
        return sn.Gait(2 * math.exp(self.swing) * math.sin(beta / 2), beta, self.rate)

    def apart(self, other: Found, steps: tuple[float, float]) -> bool:
        """Tell whether two lie in different places of a grid."""
        off = abs(self.swing - other.swing) / steps[0], abs(self.lag - other.lag) / steps[1]
        return max(off) > 1.5 or abs(math.log(self.rate / other.rate)) > 0.4


def _crossings(rates: Array, v: Array, p: Array, speed: float) -> Iterator[tuple[float, float]]:
    """Give rate and watts wherever a shape passes the speed, by straight lines in log-log."""
    with np.errstate(divide="ignore", invalid="ignore"):
        y = np.log(v / speed)
    for k in np.flatnonzero(y[:-1] * y[1:] <= 0):
        if y[k] != y[k + 1]:
            f = y[k] / (y[k] - y[k + 1])
            yield (
                float(rates[k] * (rates[k + 1] / rates[k]) ** f),
                float(p[k] * (p[k + 1] / p[k]) ** f),
            )


@dataclass(frozen=True)
class Wish:
    """Hold what is asked for."""

    table: Table
    robot: sn.Robot
    ground: sn.Ground
    speed_m_s: float
    limits: sn.GaitLimits = sn.GaitLimits()  # noqa: RUF009

    def look(self, swings: Array, lags: Array, rates: Array) -> list[Found]:
        """Return every gait of a list of shapes that makes the speed, the cheapest first."""
        beta = np.exp(lags)
        alpha = 2 * np.exp(swings) * np.sin(beta / 2)
        fit = (alpha <= min(self.limits.joint_angle_rad, math.pi)) & (beta <= math.pi)
        shapes = np.stack([swings, lags, alpha, beta], axis=1)[fit].tolist()

        def one(shape: list[float]) -> list[Found]:
            swing, lag, a, b = shape
            v, p = self.table(a, b, rates)
            found = [Found(p, swing, lag, w) for w, p in _crossings(rates, v, p, self.speed_m_s)]
            return [f for f in found if self._turns_so_fast(f.gait)]

        with ThreadPoolExecutor(2) as pool:
            return sorted((f for part in pool.map(one, shapes) for f in part), key=_watts)

    def _turns_so_fast(self, gait: sn.Gait) -> bool:
        limits = self.limits
        return (
            gait.alpha_rad * gait.omega_rad_s <= limits.servo_speed_rad_s
            and limits.omega_low_rad_s <= gait.omega_rad_s <= limits.omega_high_rad_s
        )

    def holds(self, found: Found) -> bool:
        """Tell whether the servos are strong enough for a gait."""
        most = self.limits.servo_torque_nm
        return most == math.inf or peak_torque_nm(self.robot, self.ground, found.gait) <= most

    def solved(self, found: Found) -> Found:
        """Return a gait at the rate that gives the very speed, by secants."""
        gait = found.gait

        def at(x: float) -> tuple[float, float]:
            rates = np.array([math.exp(x)])
            v, p = self.table(gait.alpha_rad, gait.beta_rad, rates)
            return math.log(v[0] / self.speed_m_s), float(p[0])

        x, y, step = math.log(found.rate), at(math.log(found.rate)), 1e-3
        for _ in range(8):
            ahead = at(x + step)
            if ahead[0] == y[0]:
                break
            x, y, step = (x + step, ahead, -ahead[0] * step / (ahead[0] - y[0]))
            if abs(y[0]) < 1e-9 or abs(step) < 1e-10:
                break
        watts = y[1] * math.exp(-2 * y[0])
        return Found(watts, found.swing, found.lag, math.exp(x))


def _watts(found: Found) -> float:
    return found.watts


def cheapest(
    wish: Wish,
    swings_rad: Array,
    lags_rad: Array,
    rates: Array,
    starts: int = 2,
    levels: int = 4,
    near: int = 5,
) -> Found | None:
    """Return the cheapest gait of a grid, followed by ever smaller ones; None for none.

    starts: so many places of the first grid are followed; levels: grids of 5 x 5 shapes and `near`
    rates that are, each half as wide as the one before.
    """
    x, y = np.log(swings_rad), np.log(lags_rad)
    steps = (np.ptp(x) / (x.size - 1), np.ptp(y) / (y.size - 1))
    begin: list[Found] = []
    for found in wish.look(*(g.ravel() for g in np.meshgrid(x, y)), rates):
        if all(found.apart(other, steps) for other in begin) and wish.holds(found):
            begin.append(found)
        if len(begin) == starts:
            break
    ends = [wish.solved(_followed(wish, one, steps, levels, near)) for one in begin]
    return min(ends, key=_watts, default=None)


def _followed(wish: Wish, best: Found, steps: tuple[float, float], levels: int, near: int) -> Found:
    """Return the cheapest gait of ever smaller grids around one."""
    box = np.stack(np.meshgrid(*[np.linspace(-1, 1, 5)] * 2), axis=-1).reshape(-1, 2)
    for level in range(levels):
        size, width = 0.5**level, max(0.3 * 0.6**level, 0.03)
        rates = best.rate * np.exp(np.linspace(-width, width, near))
        swings, lags = (
            best.swing + size * steps[0] * box[:, 0],
            best.lag + size * steps[1] * box[:, 1],
        )
        seen = next((f for f in wish.look(swings, lags, rates) if wish.holds(f)), None)
        if seen is not None and (level == 0 or seen.watts < best.watts):
            best = seen
    return best
