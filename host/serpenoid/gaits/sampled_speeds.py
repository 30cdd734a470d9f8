"""Speeds of sampled robots under one command, and what all but the slowest of them keep."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from ..model.gait import Gait
from ..model.robot import Robot
from ..periodic.neighbours import neighbours
from ..periodic.servo_steady import servo_speeds
from ..periodic.steady import from_core
from .shapes import Array
from .uncertainty import Sample

QUANTILE, KEEP = 0.05, 0.9  # so many robots may make less than this share of the wanted speed
_SLOWEST = 2.5  # times as many as make the percentile: their order changes with gait and accuracy


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
        slowest = [self.samples[k] for k in order[: self.slow_count]]
        return Samples(self.robot, slowest, self.count)

    @property
    def slow_count(self) -> int:
        """Return how many of the slowest may be those of the 5th percentile."""
        return round(_SLOWEST * QUANTILE * self.count) + 3

    def low(self, gait: Gait, smooth: bool = True) -> float:
        """Return the 5th percentile of their speeds, smoothed or plain, good to a thousandth."""
        speeds = self.speeds(gait, rough=True)
        return (smooth_low_speed if smooth else low_speed)(speeds, self.count)

    def speeds(self, gait: Gait, rough: bool = False) -> Array:
        """Return the speed of each, m/s, with its servo; 0 where none was found.

        rough: all by few steps; else those near the 5th percentile, at least, are accurate.
        """
        speeds = self._solve(range(len(self.samples)), gait, True)
        if not rough:
            slow = np.argsort(speeds)[: self.slow_count].tolist()
            speeds[slow] = self._solve(slow, gait, False)
        return speeds

    def _solve(self, which: Sequence[int], gait: Gait, rough: bool) -> Array:
        """Return the speeds of some of them."""
        samples = [self.samples[k] for k in which]
        draws = [(self.robot, sample.ground, sample.gait(gait)) for sample in samples]
        states = neighbours(draws[0], draws, rough=rough)
        self.solved += len(states)
        speeds = np.array([s.speed if s.converged else 0.0 for s in states])
        driven = [k for k, s in enumerate(samples) if s.servo is not None and speeds[k] > 0]
        if driven:
            pairs = [(from_core(*draws[k], states[k]), samples[k].servo) for k in driven]
            speeds[driven] = np.nan_to_num(servo_speeds(pairs, rough))  # pyright: ignore
        return speeds


def low_speed(speeds: Array, count: int | None = None) -> float:
    """Return the 5th percentile of speeds, or of `count` of which these are the slowest."""
    rank = QUANTILE * ((count or speeds.size) - 1)
    return float(np.interp(rank, np.arange(speeds.size), np.sort(speeds)))


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
