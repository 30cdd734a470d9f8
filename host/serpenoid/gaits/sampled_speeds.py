"""Speeds of sampled robots under one command, and what all but the slowest of them keep."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..model.core_model import core_model
from ..model.gait import Gait
from ..model.robot import Robot
from ..periodic.grid import threads_to_use
from ..periodic.servo_steady import servo_speeds
from ..periodic.steady import from_core
from .uncertainty import Sample

Array = NDArray[np.float64]
QUANTILE, KEEP = 0.05, 0.9  # so many robots may make less than this share of the wanted speed
_RTOL = 1e-3  # of speeds; a percentile of 2048 samples scatters by ten times as much
_FOLLOWED = 2.0  # times as many as make the percentile: their order changes with the gait
_FINE = 3.0  # times the percentile's rank: the slowest, whose speeds with servos are solved finely


class Samples:
    """Sampled robots; `solved` counts their states.

    count: of all samples, where these are the slowest of them.
    """

    def __init__(self, robot: Robot, samples: Sequence[Sample], count: int | None = None) -> None:
        self.robot, self.samples = robot, list(samples)
        self.count, self.solved = count or len(self.samples), 0

    def slowest(self, gait: Gait) -> Samples:
        """Return those that are slowest under a gait, more than make its 5th percentile."""
        order = np.argsort(self.speeds(gait, rough=True))
        most = round(_FOLLOWED * QUANTILE * self.count) + 8
        return Samples(self.robot, [self.samples[k] for k in order[:most]], self.count)

    def low(self, gait: Gait) -> float:
        """Return the smoothed 5th percentile of their speeds, good to a thousandth, m/s."""
        return smooth_low_speed(self.speeds(gait, rough=True), self.count)

    def speeds(self, gait: Gait, rough: bool = False) -> Array:
        """Return the speed of each, m/s, with its servo; 0 where none was found.

        rough: all by few steps; else those near the 5th percentile, at least, are accurate.
        """
        gaits = [sample.gait(gait) for sample in self.samples]
        models = [
            core_model(self.robot, sample.ground, one)
            for sample, one in zip(self.samples, gaits, strict=True)
        ]
        threads = min(threads_to_use(None), len(models))
        states = _core.neighbours(models[0], models, _RTOL, False, threads, rough=rough)
        self.solved += len(states)
        speeds = np.array([s.speed if s.converged else 0.0 for s in states])
        driven = [k for k, s in enumerate(self.samples) if s.servo is not None and speeds[k] > 0]
        ideal = {
            k: from_core(self.robot, self.samples[k].ground, gaits[k], states[k]) for k in driven
        }

        def solve(which: Sequence[int], rough: bool) -> None:
            pairs = [(ideal[k], self.samples[k].servo) for k in which]
            speeds[list(which)] = np.nan_to_num(servo_speeds(pairs, rough))  # pyright: ignore

        if driven:
            solve(driven, True)
            slow = np.argsort(speeds)[: round(_FINE * percentile_rank(self.count)) + 3].tolist()
            if not rough:
                solve([k for k in slow if k in ideal], False)
        return speeds


def percentile_rank(count: int) -> float:
    """Return the rank of the 5th percentile among `count` speeds in order, from 0."""
    return QUANTILE * (count - 1)


def low_speed(speeds: Array) -> float:
    """Return the 5th percentile of speeds."""
    return float(np.quantile(speeds, QUANTILE))


def smooth_low_speed(speeds: Array, count: int) -> float:
    """Return the 5th percentile of `count` speeds of which these are the slowest.

    As Harrell and Davis estimate it: a mean over its neighbours, less scattered than one sample,
    and smooth as the gait changes.
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
    spread = float(np.sqrt(count * QUANTILE * (1 - QUANTILE)))
    low, high = (int(np.clip(QUANTILE * count + s * spread, 0, count - 1)) for s in (-1, 1))
    return float(order[high] - order[low]) / 2
