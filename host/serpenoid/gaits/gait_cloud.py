"""A coarse table of gaits over all shapes and rates, for ranking shapes at any speed."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..model.errors import BadInput
from ..model.ground import Ground
from ..model.robot import Robot
from ..periodic.sweep import sweep
from .gait_table import Array, GaitTable
from .limits import GaitLimits
from .shape_search import Candidate, GaitShape

_VALLEYS = 6  # of the cloud, followed at most
_WITHIN, _WITHIN_DRY = 1.4, 1.6  # of the cheapest: what the cloud's coarseness may hide
_WITHIN_OTHERS, _OTHERS_APART, _OTHERS = 1.1, 0.3, 2  # cost, e-folds of shape, how many
_SWINGS = np.radians([6.0, 11, 17, 24, 31, 38, 46, 55, 66, 80])  # amplitudes of the headings
_SLOWER = np.array([0.2, 0.4, 0.6, 0.8])  # of the least of them: where servos are slow
_RATE_STEP = 1.9  # from one rate to the next: log-log lines between them err by a few per cent
_FURTHER = 4  # rates at most above the first ones, for shapes that are slow and cheap
_HOPE = 2.0  # of the cheapest: shapes between dearer ones are not solved
_FEW = 4  # shapes that reach a speed: if fewer do, all others are solved
_HIGHER = 5  # times three rates at most, while no shape reaches the speed


class _Rates(NamedTuple):
    """Hold the first rate, as omega times body length over speed, and how many follow."""

    first: float
    many: int
    rtol: float


_VISCOUS, _DRY = _Rates(4.0, 6, 1e-4), _Rates(6.0, 4, 3e-3)  # a dry gait costs 100 times as much


class GaitCloud(GaitTable):
    """A table whose shapes span every gait that travels.

    speeds: those of interest, m/s. The rates reach from slow gaits up to where no shape that is
    still too slow is cheap, or to the limits.
    """

    def __init__(
        self, robot: Robot, ground: Ground, cost: str, limits: GaitLimits, speeds: Sequence[float]
    ) -> None:
        _check_rolling(ground)
        n, rates = robot.links, _VISCOUS if ground.smooth else _DRY
        least_lag = min(math.radians(22), 2.2 / n)  # a third of a wave on the body
        lags = np.geomspace(least_lag, math.radians(165), 12 if n <= 8 else 18)
        alpha = 2 * _SWINGS[:, None] * np.sin(lags / 2)
        super().__init__(robot, ground, cost, limits, alpha, lags, rates.rtol)
        span = math.log(max(speeds) / min(speeds)) / math.log(_RATE_STEP)
        lowest = max(rates.first * min(speeds) / (n * robot.link_length_m), limits.omega_low_rad_s)
        self._coarse = np.ones(alpha.shape, bool)
        if not ground.smooth:
            self._coarse = _every_second(alpha.shape)
        self._grow(lowest * _RATE_STEP ** np.arange(rates.many + math.ceil(span)), self._coarse)
        self._reach_speed(max(speeds))
        if not ground.smooth:
            self._reach_cheap_shapes(speeds)
            self._fill_between(speeds)

    def steps_at(self, shape: GaitShape) -> Array:
        """Return the largest steps of swing and lag beside a shape of the table, e-folds."""
        swings = np.log(self.alpha_rad[:, 0] / (2 * np.sin(self.beta_rad[0, 0] / 2)))
        here = int(np.abs(swings - shape.swing).argmin())
        beside = swings[max(here - 1, 0) : here + 2]
        return np.array([np.diff(beside).max(), np.diff(np.log(self.beta_rad[0])).max()])

    def _grow(self, rates: NDArray[Any], shapes: NDArray[np.bool_] | None = None) -> None:
        self.add_rates(np.unique(np.minimum(rates, self.limits.omega_high_rad_s)), shapes)

    def _reach_speed(self, speed_m_s: float) -> None:
        """Add higher rates while none of the shapes reaches the speed."""
        for _ in range(_HIGHER):
            top = float(self.omega_rad_s[-1])
            reached = np.nanmax(self.speed_m_s, initial=0) >= speed_m_s
            beyond = top * self.alpha_rad.min() > 2 * self.limits.servo_speed_rad_s
            if reached or beyond or top >= self.limits.omega_high_rad_s:
                return
            self._grow(top * 3.0 ** np.arange(1, 4), self._coarse)

    def _reach_cheap_shapes(self, speeds: Sequence[float]) -> None:
        """Add higher rates for shapes that are too slow so far, but cost less than the cheapest."""
        for _ in range(_FURTHER):
            top = float(self.omega_rad_s[-1])
            slow = np.zeros(self.alpha_rad.shape, dtype=bool)
            for speed in speeds:
                best = np.nanmin(self.at_speed(speed)[1], initial=math.inf)
                slow |= (self.speed_m_s[:, :, -1] < speed) & (self.cost_w[:, :, -1] < best)
            if top >= self.limits.omega_high_rad_s or not slow.any():
                return
            self._grow(np.array([_RATE_STEP * top]), slow)

    def _fill_between(self, speeds: Sequence[float]) -> None:
        """Solve shapes beside cheap ones, at the rates that those need, until none is left."""
        solved = self._coarse.copy()
        while True:
            first, last = self._hopeful(speeds)
            new = (last > first) & ~solved
            if not new.any():
                return
            self.fill(first, np.where(new, last, first))
            solved |= new

    def _hopeful(self, speeds: Sequence[float]) -> tuple[Array, Array]:
        """Return from which to which rate, by number, shapes may be cheap, by those around them."""
        count = self.omega_rad_s.size
        first, last = np.full(self._coarse.shape, count), np.zeros(self._coarse.shape, int)
        for speed in speeds:
            rate, watts = self.at_speed(speed)
            known = np.isfinite(watts)
            if known.sum() < _FEW:
                return np.zeros_like(first), np.full_like(last, count)
            hopeful = _around(np.where(known, watts, np.inf), np.min) <= _HOPE * watts[known].min()
            low = _around(np.where(known, rate, np.inf), np.min)
            high = _around(np.where(known, rate, -np.inf), np.max)
            below = np.searchsorted(self.omega_rad_s, low) - 1
            above = np.searchsorted(self.omega_rad_s, high) + 1
            first = np.where(hopeful, np.minimum(first, np.maximum(below, 0)), first)
            last = np.where(hopeful, np.maximum(last, np.minimum(above, count)), last)
        return first, last

    def at_speed(self, speed_m_s: float) -> tuple[Array, Array]:
        """Return rate and cost of every shape at a speed, (S, L); NaN where none gives it.

        Below the lowest rate, speed goes as the rate and cost as its square.
        """
        rate, watts = super().at_speed(speed_m_s)
        with np.errstate(divide="ignore", invalid="ignore"):
            f = speed_m_s / self.speed_m_s[:, :, 0]
            fast = (f < 1) & np.isnan(rate)
            rate = np.where(fast, f * self.omega_rad_s[0], rate)
            return rate, np.where(fast, f**2 * self.cost_w[:, :, 0], watts)

    def starts(self, speed: float) -> list[Candidate]:
        """Return the valleys that may hold the minimum.

        A narrow dry valley may cross the cloud between its shapes: then other cheap shapes lie in
        it, too.
        """
        if self.ground.smooth:
            return self.candidates(speed, _VALLEYS, _WITHIN)
        starts = self.candidates(speed, _VALLEYS, _WITHIN_DRY)
        others = 0
        for one in self.shapes_within(speed, _WITHIN_OTHERS):
            apart = [np.abs(np.subtract(one.shape, start.shape)).max() for start in starts]
            if others < _OTHERS and min(apart, default=0) > _OTHERS_APART:
                starts, others = [*starts, one], others + 1
        return starts

    def fastest(self) -> tuple[float, float, float, float]:
        """Return speed, alpha, beta and rate of the fastest gait found within the limits."""
        return max(self._fastest_of_table(), self._fastest_of_servos())

    def _fastest_of_servos(self) -> tuple[float, float, float, float]:
        """Return the fastest gait at the rate that the servos' speed allows, or less."""
        best, limits = (0.0, 0.0, 0.0, 0.0), self.limits
        if limits.servo_speed_rad_s == math.inf:
            return best
        small = self.alpha_rad[:1] * _SLOWER[:, None]
        alphas = np.concatenate([small, self.alpha_rad])
        for (_, j), alpha in np.ndenumerate(alphas):
            if alpha > min(limits.joint_angle_rad, math.pi):
                continue
            top = min(limits.servo_speed_rad_s / alpha, limits.omega_high_rad_s)
            rates, beta = np.array([0.25, 0.5, 1.0]) * top, float(self.beta_rad[0, j])
            found = sweep(
                self.robot,
                self.ground,
                alpha_rad=alpha,
                beta_rad=beta,
                omega_rad_s=rates,
                rtol=1e-3,
                powers=False,
                threads=1,
            )
            v = np.where(found.converged, found.speed_m_s, 0.0)[0, 0]
            k = int(v.argmax())
            best = max(best, (float(v[k]), float(alpha), beta, float(rates[k])))
        return best

    def _fastest_of_table(self) -> tuple[float, float, float, float]:
        rate = np.broadcast_to(self.omega_rad_s, self.speed_m_s.shape)
        allowed = self.alpha_rad[:, :, None] * rate <= self.limits.servo_speed_rad_s * 1.0000001
        v = np.where(allowed & np.isfinite(self.speed_m_s), self.speed_m_s, 0.0)
        i, j, k = np.unravel_index(int(np.argmax(v)), v.shape)
        return v[i, j, k], self.alpha_rad[i, j], self.beta_rad[i, j], rate[i, j, k]


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


def _every_second(shape: tuple[int, ...]) -> NDArray[np.bool_]:
    """Return a mask of every second row and column, and of the last ones."""
    rows, columns = (np.arange(size) for size in shape)
    return np.outer(
        (rows % 2 == 0) | (rows == shape[0] - 1), (columns % 2 == 0) | (columns == shape[1] - 1)
    )


def _around(values: Array, least: Callable[..., Array]) -> Array:
    """Return the least, or greatest, of every entry and its eight neighbours."""
    edge = math.inf if least is np.min else -math.inf
    padded = np.pad(values, 1, constant_values=edge)
    views = np.lib.stride_tricks.sliding_window_view(padded, (3, 3))
    return least(views, axis=(2, 3))
