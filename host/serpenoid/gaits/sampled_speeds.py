"""Speeds of sampled robots under one command, with as few cycles followed as their order allows.

Each state is looked for where a linear fit to the states of other samples expects it. One cycle
then mostly gives a rough speed, good to a thousandth. Where the 5th percentile is wanted, the
samples near it are solved by two levels, whose difference bounds their errors; the others only
need be on their side of it.
"""

from __future__ import annotations

from collections.abc import Sequence
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
from ..periodic.servo_steady import servo_speeds
from ..periodic.steady import MAX_ELEMENTS, Steady, steady_gait
from .uncertainty import Sample

Array = NDArray[np.float64]
Places = NDArray[np.intp]
QUANTILE = 0.05
_RTOL = 3e-3
_IDEAL_RTOL, _LEAST_M_S = 1e-3, 1e-9
_FOR_FIT = 3  # samples for each coefficient of the linear fit
_NEAR = 0.03  # relative: rough speeds this near to the percentile are solved by two levels
_WIDER = 4.0  # times the largest error seen of a rough speed: near is at least that
_CLOSER = 4  # times at most that new samples come near


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
    """

    def __init__(
        self, robot: Robot, samples: Sequence[Sample], shares: ServoShares | None = None
    ) -> None:
        self.robot, self.samples, self.shares, self.solved = robot, samples, shares, 0
        self.dry = any(not sample.ground.smooth for sample in samples)
        traits = np.array([_traits(sample) for sample in samples])
        spread = traits.std(axis=0)
        varied = spread > 1e-9
        unit = (traits[:, varied] - traits[:, varied].mean(axis=0)) / spread[varied]
        self._terms = np.hstack([np.ones((len(samples), 1)), unit])

    def rough(self, gait: Gait, which: Places) -> Array:
        """Return speeds of some samples, m/s, good to a thousandth or so; 0: none was found."""
        return _speeds(self._rough(gait, which)) * self._left(gait, which)

    def near_percentile(self, gait: Gait, which: Places, rank: float) -> Array:
        """Return speeds of some samples, m/s; those near the one of this rank to 3e-3 at least."""
        states = self._rough(gait, which)
        left, done = self._left(gait, which), np.zeros(which.size, bool)
        speeds = _speeds(states) * left
        near = _NEAR
        for _ in range(_CLOSER if self.dry else 0):
            middle = np.sort(speeds)[round(rank)]
            unsure = ~done & ((abs(speeds - middle) <= near * middle) | (speeds == 0))
            if not unsure.any():
                break
            picked = np.flatnonzero(unsure)
            starts = [states[i].start for i in picked]
            fine = _speeds(self._solve(gait, which[picked], False, starts)) * left[picked]
            off = abs(fine - speeds[picked]) / np.maximum(fine, 1e-300)
            near = max(near, _WIDER * float(off[speeds[picked] > 0].max(initial=0.0)))
            speeds[picked], done = fine, done | unsure
        return speeds

    def _left(self, gait: Gait, which: Places) -> Array:
        """Return what the samples' servos leave of their speeds."""
        if self.shares is None:
            return np.ones(which.size)
        return self.shares.of(gait, [self.samples[i] for i in which])

    def _rough(self, gait: Gait, which: Places) -> list[Any]:
        """Solve for rough states: first some from one state, then the others by a fit to those."""
        first = _FOR_FIT * self._terms.shape[1]
        if not self.dry or which.size < 2 * first:
            return self._solve(gait, which, self.dry, [])
        states = self._solve(gait, which[:first], True, [])
        good = [k for k, s in enumerate(states) if s.converged]
        found = np.array([states[k].start for k in good]).reshape(-1, 3)
        fit = np.linalg.lstsq(self._terms[which[good]], found, rcond=None)[0]
        starts = (self._terms[which[first:]] @ fit).tolist()
        return states + self._solve(gait, which[first:], True, starts)

    def _solve(self, gait: Gait, which: Places, rough: bool, starts: list[Any]) -> list[Any]:
        self.solved += which.size
        return _solve(self.robot, gait, [self.samples[i] for i in which], rough, starts)


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
    from scipy.stats import beta

    order = np.sort(speeds)
    a, b = (count + 1) * QUANTILE, (count + 1) * (1 - QUANTILE)
    weight = np.diff(beta.cdf(np.arange(order.size + 1) / count, a, b))
    return float(weight @ order / weight.sum())


def low_speed_error(speeds: Array) -> float:
    """Return the standard error of the 5th percentile of samples, from those around it."""
    order, count = np.sort(speeds), speeds.size
    spread = percentile_spread(count)
    low, high = (int(np.clip(QUANTILE * count + s * spread, 0, count - 1)) for s in (-1, 1))
    return float(order[high] - order[low]) / 2


def percentile_spread(count: int) -> float:
    """Return the standard deviation of the number of samples below the true 5th percentile."""
    return float(np.sqrt(count * QUANTILE * (1 - QUANTILE)))
