"""Tempered particles: from draws of one density to draws of another, whatever its shape.

Between the first density p and the last q stand p (q / p)^t with t from 0 to 1. Each step of t is
as long as leaves half of the particles independent; then each particle moves by the difference of
two others (differential evolution, ter Braak 2006), which follows the shape that they have.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
LogDensity = Callable[[Floats], Floats]

FREEDOM, WIDER = 6.0, 1.15  # Student's distribution about a mode: freedom, and width
MOVES = 6  # moves of a particle after a step; twice as many after the last
_LENGTHS = (0.2, 0.4, 0.6, 1.0)  # lengths of a move, as shares of the difference of two particles
_JITTER = 0.02  # standard deviations of the particles
_CROSSOVERS = (0.2, 0.5, 1.0)  # shares of the parameters that a move changes
_JUMP_SHARE = 0.1  # share of moves by the whole difference, from one maximum to another
_SNAPSHOTS = 4  # Sets of all samples that are kept, a fixed number of moves apart


@dataclass(frozen=True)
class Student:
    """Student's distribution about a centre (D,), with a lower root (D, D) made somewhat wider.

    normal: how many of the last coordinates are normal given the first: whole tails in many
    dimensions would be tails far out.
    """

    centre: Floats
    root: Floats
    normal: int = 0

    def points(self, count: int, seed: int) -> Floats:
        """Return (count, D) random points of it."""
        rng, heavy = np.random.default_rng(seed), len(self.centre) - self.normal
        unit = WIDER * rng.standard_normal((count, len(self.centre)))
        unit[:, :heavy] /= np.sqrt(rng.chisquare(FREEDOM, (count, 1)) / FREEDOM)
        return np.asarray(self.centre + unit @ self.root.T)

    def log_density(self, x: Floats) -> Floats:
        """Return its logarithm at points (K, D)."""
        from scipy.special import gammaln

        root, size = WIDER * self.root, len(self.centre) - self.normal
        square = np.linalg.solve(root, (x - self.centre).T) ** 2
        head = gammaln((FREEDOM + size) / 2) - gammaln(FREEDOM / 2) - np.linalg.slogdet(root)[1]
        tails = (FREEDOM + size) * np.log1p(np.sum(square[:size], axis=0) / FREEDOM)
        tails = tails + np.sum(square[size:], axis=0) + self.normal * math.log(2 * math.pi)
        return np.asarray(head - 0.5 * (size * math.log(FREEDOM * math.pi) + tails))


def explored(x: Floats, log_density: LogDensity, moves: int, rng: np.random.Generator) -> Floats:
    """Return samples (M, N, D) of a density, from M equally spaced moves of the second half.

    x (N, D): where they begin, about the maxima. Each sample moves by the difference of two others
    in all of its parameters or in some (differential evolution with crossover, Vrugt 2009). The
    first follows a narrow ridge, the second widens parameters that the density hardly limits.
    """
    count = len(x)
    log, snapshots = log_density(x), []
    for k in range(moves):
        pair = x[rng.permutation(count)] - x[rng.permutation(count)]
        pair += _JITTER * x.std(axis=0) * rng.normal(size=x.shape)
        moved = rng.random(x.shape) < rng.choice(_CROSSOVERS, size=(count, 1))
        length = rng.uniform(0.5, 1.7, (count, 1)) / np.sqrt(np.maximum(moved.sum(1), 1))[:, None]
        tried = x + np.where(rng.random((count, 1)) < _JUMP_SHARE, 1.0, length) * moved * pair
        new = log_density(tried)
        accepted = np.log(rng.random(count)) < new - log
        x, log = np.where(accepted[:, None], tried, x), np.where(accepted, new, log)
        if k >= moves // 2 and (moves - 1 - k) % (moves // (2 * _SNAPSHOTS)) == 0:
            snapshots.append(x)
    return np.array(snapshots)


def effective_count(log: Floats) -> float:
    """Return how many points that are alike are worth as much as weights of such logarithms."""
    weight = np.exp(log - log.max())
    return float(weight.sum() ** 2 / np.sum(weight**2))


def tempered(
    x: Floats,
    first: LogDensity,
    ratio: LogDensity,
    rng: np.random.Generator,
    moves: int = MOVES,
) -> tuple[Floats, float]:
    """Return particles (N, D) of the last density from such of the first.

    And the logarithm of the last density's integral over the first one's. ratio: of the last
    density to the first, a likelihood where the first is what was known before. All unknowns change
    in a move: with some of them alone, particles would stay where they are on a narrow ridge.
    """
    count, power, integral = len(x), 0.0, 0.0
    log_first, log_ratio = first(x), ratio(x)
    while power < 1.0:
        rise = np.where(np.isfinite(log_ratio), log_ratio, -np.inf)
        step = _step(rise, 1.0 - power)
        power = min(power + step, 1.0)
        weight = np.exp(step * (rise - rise.max()))
        integral += step * float(rise.max()) + math.log(weight.mean())
        rows = np.searchsorted(
            np.cumsum(weight / weight.sum()), (np.arange(count) + rng.random()) / count
        )
        rows = np.minimum(rows, count - 1)
        x, log_first, log_ratio = x[rows], log_first[rows], log_ratio[rows]
        for _ in range(moves if power < 1.0 else 2 * moves):
            pair = x[rng.permutation(count)] - x[rng.permutation(count)]
            jitter = _JITTER * x.std(axis=0) * rng.normal(size=x.shape)
            tried = x + (rng.choice(_LENGTHS, size=(count, 1)) * pair + jitter)
            new_first, new_ratio = first(tried), ratio(tried)
            gain = new_first - log_first + power * (new_ratio - log_ratio)
            accepted = np.log(rng.uniform(size=count)) < gain
            x = np.where(accepted[:, None], tried, x)
            log_first = np.where(accepted, new_first, log_first)
            log_ratio = np.where(accepted, new_ratio, log_ratio)
    return x, integral


def _step(rise: Floats, limit: float) -> float:
    """Return how far the power may rise: half of the particles stay independent."""
    if effective_count(limit * rise) >= len(rise) / 2:
        return limit
    low, high = 0.0, limit
    for _ in range(40):
        middle = (low + high) / 2
        low, high = (
            (middle, high) if effective_count(middle * rise) > len(rise) / 2 else (low, middle)
        )
    return max(low, 1e-6)
