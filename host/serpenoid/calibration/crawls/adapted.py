"""Weighted points of a density with one mode: a distribution follows their moments."""

from __future__ import annotations

import math

import numpy as np

from ...model.particles import Floats, LogDensity, Student, alike

ENOUGH = 0.3  # of the points: as many independent ones
_SOFT, _ROUNDS = 0.2, 5  # of the points, softened, for moments; and how often those are taken


def softened(log: Floats, least: float) -> Floats:
    """Return weights, sum 1, by the highest power of exp(log) that leaves so many alike."""
    power = 1.0
    while alike(power * log) < least:
        power /= 1.3
    weight = np.exp(power * (log - log.max()))
    return np.asarray(weight / weight.sum())


def adapted(
    about: Student, last: LogDensity, seed: int, count: int
) -> tuple[Floats, Floats, float]:
    """Return points (N, D) of a density with one mode, their weights, and its log integral.

    They are drawn from a distribution about the mode, which then follows their moments, until
    enough of them count. count: a power of two.
    """
    most, best = 0.0, None
    for part in range(_ROUNDS):
        x = about.points(count, seed + part)
        log = last(x) - about.log_density(x)
        if alike(log) > most:
            weight, most = np.exp(log - log.max()), alike(log)
            best = x, weight / weight.sum(), float(log.max()) + math.log(weight.mean())
        if most >= ENOUGH * count:
            break
        soft = softened(log, _SOFT * count)
        root = np.linalg.cholesky(np.cov(x.T, aweights=soft))
        about = Student(soft @ x, np.asarray(root, dtype=np.float64))
    assert best is not None  # one round at least
    return best
