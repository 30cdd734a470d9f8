"""Speeds of sampled robots under one command, with as few cycles followed as their order allows.

Each state is looked for where a fit to the states of other samples, or of other gaits, expects it.
One cycle then mostly gives a rough speed, good to a thousandth. Where the 5th percentile is wanted,
the samples near it are solved by two levels, whose difference bounds their errors; the others only
need be on their side of it. A search that goes from gait to gait solves only the samples near the
percentile, and follows the others by fits.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from functools import lru_cache
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..model.core_model import core_model
from ..model.drives import Servo
from ..model.errors import NotConverged
from ..model.gait import Gait
from ..model.ground import Ground
from ..model.robot import Robot
from ..periodic.grid import threads_to_use
from ..periodic.near_states import LocalFit
from ..periodic.servo_steady import servo_speeds
from ..periodic.steady import MAX_ELEMENTS, Steady, steady_gait
from .shape_search import GaitShape
from .uncertainty import Sample

Array = NDArray[np.float64]
Places = NDArray[np.intp]
QUANTILE = 0.05
_RTOL = 3e-3
_IDEAL_RTOL, _LEAST_M_S = 1e-3, 1e-9
_SAME = 1e-9  # spread of a trait, below which samples do not differ in it
_STIFF = 5.0  # samples: a coefficient is believed as far as more of them tell it
_FIRST = 4  # samples that tell how far all states are from where they were expected
_FOR_FIT, _MOST_TERMS = 3, 200  # samples for each coefficient of a fit; its coefficients
_NEAR = 0.01  # relative: rough speeds this near to the percentile are solved by two levels
_WIDER = 4.0  # times the largest error seen of a rough speed: near is at least that
_CLOSER = 4  # times at most that new samples come near
_SAME_RATE = 0.03  # e-folds: so near another rate's speeds, a shape's slow samples are known
_RATE_SLOPE = 1.3  # of ln speed against ln rate, where no gaits tell it
_TELLS = 0.35  # e-folds of shape and rate: farther gaits tell nothing of the order of samples
_RANKS = 1.5  # standard deviations of the percentile's rank: these samples make it
_MARGIN = 2.0  # times what expected speeds miss: so near to those others are solved, too


class ServoShares:
    """The speed with a servo over that of ideal joints, on one ground.

    A servo costs several times an ideal gait, and few are among the slowest samples. So the share
    of each servo is solved for roughly, once a gait, on the nominal ground, and serves all samples.
    That is 3 to 4 % off in the median; the check of a robust gait solves each robot for itself.
    """

    def __init__(self, robot: Robot, ground: Ground) -> None:
        self._robot, self._ground = robot, ground
        self._known: dict[Gait, dict[Servo, float]] = {}

    def of(self, gait: Gait, samples: Sequence[Sample]) -> Array:
        """Return the share of each sample's servo, 1 where it has none."""
        known = self._known.setdefault(gait, {})
        new = list({s.servo: None for s in samples if s.servo is not None and s.servo not in known})
        if new:
            ideal = steady_gait(self._robot, self._ground, gait, rtol=_IDEAL_RTOL, powers=False)
            speeds = servo_speeds(((ideal, one) for one in new), rough=True)
            shares = np.nan_to_num(speeds) / max(ideal.speed_m_s, _LEAST_M_S)
            known.update(zip(new, shares.tolist(), strict=True))
        return np.array([1.0 if s.servo is None else known[s.servo] for s in samples])


def sampled_speeds(
    robot: Robot, gait: Gait, samples: Sequence[Sample], shares: ServoShares | None = None
) -> Array:
    """Return the speed of each sampled robot under one command, m/s; 0 where none was found.

    shares: what each sample's servo leaves of it; None: ideal joints.
    """
    speeds = _speeds(_solve(robot, gait, samples, False, []))
    return speeds if shares is None else speeds * shares.of(gait, samples)


def _speeds(states: list[Any]) -> Array:
    return np.nan_to_num([s.speed if s.converged else 0.0 for s in states])


def _solve(
    robot: Robot, gait: Gait, samples: Sequence[Sample], rough: bool, starts: list[Any]
) -> list[Any]:
    models = [core_model(robot, s.ground, gait, (s.joint_gain, s.joint_shift_rad)) for s in samples]
    threads = min(threads_to_use(None), len(models))
    return _core.neighbours(
        models[0], models, _RTOL, False, MAX_ELEMENTS, threads, rough=rough, starts=starts
    )


class SampledSpeeds:
    """Solve sampled robots under one command after another. `solved` counts their states.

    shares: what each sample's servo leaves of its speed; None: ideal joints.
    like: other samples, whose states tell where these begin.
    starts: of every sample's last state, over the rate, (N, 3); NaN where there is none.
    """

    def __init__(
        self,
        robot: Robot,
        samples: Sequence[Sample],
        shares: ServoShares | None = None,
        like: SampledSpeeds | None = None,
    ) -> None:
        self.robot, self.samples, self.shares, self.solved = robot, samples, shares, 0
        self.dry = any(not sample.ground.smooth for sample in samples)
        traits = np.array([_traits(sample) for sample in samples])
        self._like = like or self
        if like is None:
            self._middle, self._spread = traits.mean(axis=0), traits.std(axis=0)
        else:
            self._middle, self._spread = like._middle, like._spread
        varied = self._spread > _SAME
        self._unit = (traits[:, varied] - self._middle[varied]) / self._spread[varied]
        self.starts = np.full((len(samples), 3), np.nan)
        self._gaits = np.full((len(samples), 3), np.nan)  # alpha, beta, ln rate of the last state
        self._speeds = np.zeros(len(samples))

    def rough(self, gait: Gait, which: Places) -> Array:
        """Return speeds of some samples, m/s, good to a thousandth or so; 0: none was found."""
        if not self.dry:
            self.solve(gait, which, False, None)
            return self._speeds[which] * self._left(gait, which)
        before = self.begin(which)
        for count, rows in self._stages(which.size, before is not None):
            self.solve(gait, which[rows], True, self._expected(which, before, count, rows))
        return self._speeds[which] * self._left(gait, which)

    def ranked(self, gait: Gait, which: Places) -> Array:
        """Return speeds of some samples, m/s, good enough to tell the slow ones.

        Those solved for the same shape at a rate near this one are not solved again.
        """
        if not self.dry:
            return self.rough(gait, which)
        apart = _numbers(gait) - self._gaits[which]
        new = (apart[:, :2] != 0).any(axis=1) | ~(abs(apart[:, 2]) < _SAME_RATE)
        if new.any():
            self.rough(gait, which[new])
        at_rate = np.where(new, 1.0, np.exp(_RATE_SLOPE * apart[:, 2]))
        return at_rate * self._speeds[which] * self._left(gait, which)

    def near_percentile(self, gait: Gait, which: Places, rank: float) -> Array:
        """Return speeds of some samples, m/s; those near the one of this rank to 3e-3 at least."""
        speeds = self.ranked(gait, which)
        done = np.zeros(which.size, bool)
        near = _NEAR
        for _ in range(_CLOSER if self.dry else 0):
            middle = np.sort(speeds)[round(rank)]
            unsure = ~done & ((abs(speeds - middle) <= near * middle) | (speeds == 0))
            if not unsure.any():
                break
            fine = self.solve(gait, which[unsure], False, self.starts[which[unsure]])
            off = abs(fine - speeds[unsure]) / np.maximum(fine, 1e-300)
            near = max(near, _WIDER * float(off[speeds[unsure] > 0].max(initial=0.0)))
            speeds[unsure], done = fine, done | unsure
        return speeds

    def solve(self, gait: Gait, which: Places, rough: bool, starts: Array | None) -> Array:
        """Return speeds of some samples, m/s; 0: none was found.

        starts: over the rate, (K, 3); None: from the first one's state.
        """
        rate = gait.omega_rad_s
        begin = [] if starts is None else (rate * np.nan_to_num(starts)).tolist()
        states = _solve(self.robot, gait, [self.samples[i] for i in which], rough, begin)
        self.solved += which.size
        self._gaits[which], self._speeds[which] = _numbers(gait), _speeds(states)
        found = np.array([s.converged for s in states])[:, None]
        self.starts[which] = np.where(found, np.array([s.start for s in states]) / rate, np.nan)
        return self._speeds[which] * self._left(gait, which)

    def _left(self, gait: Gait, which: Places) -> Array:
        """Return what the samples' servos leave of their speeds."""
        if self.shares is None:
            return np.ones(which.size)
        return self.shares.of(gait, [self.samples[i] for i in which])

    def begin(self, which: Places) -> Array | None:
        """Return starts: those of the gaits before, and a fit's for samples without one."""
        starts, like = self.starts[which].copy(), self._like
        new, known = np.isnan(starts).any(axis=1), np.isfinite(like.starts).all(axis=1)
        if new.any():
            told = [count for count in self._counts() if _FOR_FIT * count <= known.sum()]
            if not told:
                return None
            fit = _fit(like._terms(np.flatnonzero(known), told[-1]), like.starts[known])
            starts[new] = self._terms(which[new], told[-1]) @ fit
        return starts

    def _counts(self) -> list[int]:
        """Return how many terms a linear fit has, and one with squares where they are few."""
        linear = 1 + self._unit.shape[1]
        squares = linear * (linear + 1) // 2
        return [linear, squares] if squares <= _MOST_TERMS else [linear]

    def _terms(self, which: Places, count: int) -> Array:
        """Return the first terms: 1, the traits in which samples differ, all their products."""
        unit = self._unit[which]
        i, j = np.triu_indices(unit.shape[1] if count > 1 + unit.shape[1] else 0)
        return np.hstack([np.ones((which.size, 1)), unit, unit[:, i] * unit[:, j]])[:, :count]

    def _stages(self, size: int, told: bool) -> Iterator[tuple[int, slice]]:
        """Give rows to solve at a time, and with how many terms to fit the rows before them.

        told: there are starts, and of a fit only the mean serves, which says how all have moved.
        """
        counts = [0, 1] if told else [0, 1, *self._counts()]
        ends = [_FIRST, *(max(_FIRST, _FOR_FIT * count) for count in counts[2:]), size]
        for count, (first, last) in zip(counts, pairwise([0, *ends]), strict=True):
            if first < min(last, size):
                yield count, slice(first, min(last, size))

    def _expected(
        self, which: Places, before: Array | None, count: int, rows: slice
    ) -> Array | None:
        """Return starts of rows: those before, and how a fit to earlier rows moves them."""
        if count == 0:
            return None if before is None else before[rows]
        base = np.zeros((which.size, 3)) if before is None else before
        done = slice(0, rows.start)
        moved = self.starts[which[done]] - base[done]
        good = np.isfinite(moved).all(axis=1)
        fit = _fit(self._terms(which[done], count)[good], moved[good])
        return base[rows] + self._terms(which[rows], count) @ fit


class FollowedSamples:
    """The low speed of some samples under one gait after another, for few of them solved anew.

    Fits to the gaits before expect each sample's speed and start. Those near the percentile are
    solved; what they miss on the whole, all others are taken to miss. count: of all samples, whose
    slowest these are.
    """

    def __init__(self, robots: SampledSpeeds, which: Places, count: int) -> None:
        self.robots, self.which, self.count = robots, which, count
        self._known = LocalFit(3, 4 * which.size)  # by swing, lag and ln rate

    def low(self, gait: Gait) -> float:
        """Return the smoothed 5th percentile of the speed, m/s."""
        at = np.array([*GaitShape.of(gait.alpha_rad, gait.beta_rad), math.log(gait.omega_rad_s)])
        if self._known.nearest(at) < _TELLS:
            states = self._known.expect(at[None]).reshape(-1, 4)
            states[:, 0] += _RATE_SLOPE * at[2]
            self._solve_near_percentile(gait, states)
        else:
            logs = _logs(self.robots.ranked(gait, self.which))
            states = np.column_stack([logs, np.nan_to_num(self.robots.starts[self.which])])
        speeds = np.exp(states[:, 0])
        states[:, 0] -= _RATE_SLOPE * at[2]
        self._known.add(at[None], states.reshape(1, -1))
        return smooth_low_speed(speeds, self.count)

    def _solve_near_percentile(self, gait: Gait, states: Array) -> None:
        """Put right what is expected: ln speed, m/s, and start over the rate of each sample.

        At first a few samples tell what all are off by.
        """
        middle, wide = percentile_rank(self.count), _RANKS * percentile_spread(self.count)
        ranks = np.ceil([middle - _FIRST / 2, middle - wide, middle + wide]).astype(int)
        begin, first, last = np.clip(ranks, 0, len(states) - 1)
        picked = np.argsort(states[:, 0])[begin : begin + _FIRST]
        solved, margin = np.zeros(len(states), bool), 0.0
        for _ in range(_CLOSER):
            off = self._solved(gait, picked, states[picked, 1:]) - states[picked]
            off[:, 1:] = np.nan_to_num(off[:, 1:])
            shift = np.median(off, axis=0)
            states[picked] += off
            solved[picked] = True
            states[~solved] += shift
            margin = max(margin, _MARGIN * float(np.sqrt(np.mean((off - shift)[:, 0] ** 2))))
            low, high = np.sort(states[:, 0])[[first, last]] + [-margin, margin]
            picked = np.flatnonzero(~solved & (states[:, 0] >= low) & (states[:, 0] <= high))
            if not picked.size:
                break

    def _solved(self, gait: Gait, picked: Places, starts: Array) -> Array:
        """Return ln speed and start of some samples, (K, 4); NaN for a start not found."""
        which = self.which[picked]
        speeds = self.robots.solve(gait, which, self.robots.dry, starts)
        return np.column_stack([_logs(speeds), self.robots.starts[which]])


def _fit(terms: Array, values: Array) -> Array:
    """Return the coefficients of a fit; those that few values tell stay small, but for the mean."""
    stiff = np.full(terms.shape[1], _STIFF)
    stiff[0] = _SAME
    return np.linalg.solve(terms.T @ terms + np.diag(stiff), terms.T @ values)


def _logs(speeds: Array) -> Array:
    return np.log(np.maximum(speeds, _LEAST_M_S))


def _numbers(gait: Gait) -> Array:
    return np.array([gait.alpha_rad, gait.beta_rad, math.log(gait.omega_rad_s)])


def _traits(sample: Sample) -> list[float]:
    """Return the numbers in which samples differ: logarithms of frictions; gains and shifts."""
    g = sample.ground
    frictions = (g.ct_forward, g.ct_backward, g.cn, g.ft0_forward, g.ft0_backward, g.fn0)
    logs = np.log(np.maximum(frictions, 1e-300)).tolist()
    return [*logs, *sample.joint_gain, *sample.joint_shift_rad]


def driven_speeds(robot: Robot, gait: Gait, samples: Sequence[Sample]) -> Array:
    """Return each sampled robot's speed with its own servo, m/s; 0 where none was found."""
    speeds = np.zeros(len(samples))
    pairs: dict[int, tuple[Steady, Servo]] = {}
    for k, sample in enumerate(samples):
        try:
            own = sample.gait(gait)
            ideal = steady_gait(robot, sample.ground, own, rtol=_IDEAL_RTOL, powers=False)
        except NotConverged:
            continue
        speeds[k] = ideal.speed_m_s
        if sample.servo is not None:
            pairs[k] = (ideal, sample.servo)
    if pairs:
        speeds[list(pairs)] = np.nan_to_num(servo_speeds(pairs.values()))
    return speeds


def percentile_rank(count: int) -> float:
    """Return the rank of the 5th percentile among `count` speeds in order, from 0."""
    return QUANTILE * (count - 1)


def low_speed(speeds: Array, count: int) -> float:
    """Return the 5th percentile of `count` speeds of which these are the slowest."""
    order = np.sort(speeds)
    at = percentile_rank(count)
    k = min(int(at), order.size - 2)
    return float(order[k] + (at - k) * (order[k + 1] - order[k]))


def smooth_low_speed(speeds: Array, count: int) -> float:
    """Return the same percentile as Harrell and Davis estimate it: a mean over its neighbours.

    Less scattered than one sample, and smooth as the gait changes.
    """
    return float(_harrell_davis(speeds.size, count) @ np.sort(speeds))


@lru_cache
def _harrell_davis(slowest: int, count: int) -> Array:
    """Return the weights of the slowest of `count` values in order."""
    from scipy.stats import beta

    a, b = (count + 1) * QUANTILE, (count + 1) * (1 - QUANTILE)
    weight = np.diff(beta.cdf(np.arange(slowest + 1) / count, a, b))
    return weight / weight.sum()


def low_speed_error(speeds: Array) -> float:
    """Return the standard error of the 5th percentile of samples, from those around it."""
    order, count = np.sort(speeds), speeds.size
    spread = percentile_spread(count)
    low, high = (int(np.clip(QUANTILE * count + s * spread, 0, count - 1)) for s in (-1, 1))
    return float(order[high] - order[low]) / 2


def percentile_spread(count: int) -> float:
    """Return the standard deviation of the number of samples below the true 5th percentile."""
    return float(np.sqrt(count * QUANTILE * (1 - QUANTILE)))
