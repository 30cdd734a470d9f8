"""Sample densities: weighted points about a mode, and an ensemble for any shape."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
LogDensity = Callable[[Floats], Floats]


def points_about(
    mode: Floats,
    root: Floats,
    normal: int,
    count: int,
    rng: np.random.Generator,
    *,
    freedom: float = 6.0,
    width: float = 1.15,
) -> tuple[Floats, Floats]:
    """Return random points (count, D) about a mode (D,), and the logarithms of their density.

    They have Student's t distribution with `freedom` degrees of freedom; its scale is a lower root
    (D, D) of a covariance, times width.
    normal: number of last coordinates that are normal given the first ones, since heavy tails in
    many dimensions would put all points far out. The logarithms (count,) lack a constant.
    """
    size = len(mode) - normal
    unit = rng.standard_normal((count, len(mode)))
    unit[:, :size] /= np.sqrt(rng.chisquare(freedom, (count, 1)) / freedom)
    tails = (freedom + size) * np.log1p(np.sum(unit[:, :size] ** 2, axis=1) / freedom)
    log_density = -0.5 * (tails + np.sum(unit[:, size:] ** 2, axis=1))
    return mode + width * unit @ root.T, log_density


def explored(
    x: Floats,
    log_density: LogDensity,
    moves: int,
    rng: np.random.Generator,
    *,
    jitter: float = 0.02,
    crossovers: tuple[float, ...] = (0.2, 0.5, 1.0),
    jump_share: float = 0.1,
    sets: int = 4,
) -> Floats:
    """Return sets of samples (sets, N, D) of a density, from equally spaced late moves.

    x: (N, D), start of the ensemble, about the maxima. Each sample moves by the difference of two
    others in all parameters, which follows narrow ridges, or in some, which widens parameters that
    the density hardly limits (differential evolution with crossover, Vrugt 2009).
    jitter: scatter added to a move, in standard deviations of the samples. crossovers: shares of
    the parameters that a move changes. jump_share: share of moves by the whole difference, from one
    maximum to another.
    """
    count = len(x)
    log, snapshots = log_density(x), []
    for k in range(moves):
        pair = x[rng.permutation(count)] - x[rng.permutation(count)]
        pair += jitter * x.std(axis=0) * rng.normal(size=x.shape)
        moved = rng.random(x.shape) < rng.choice(crossovers, size=(count, 1))
        length = rng.uniform(0.5, 1.7, (count, 1)) / np.sqrt(np.maximum(moved.sum(1), 1))[:, None]
        tried = x + np.where(rng.random((count, 1)) < jump_share, 1.0, length) * moved * pair
        new = log_density(tried)
        accepted = np.log(rng.random(count)) < new - log
        x, log = np.where(accepted[:, None], tried, x), np.where(accepted, new, log)
        if k >= moves // 2 and (moves - 1 - k) % (moves // (2 * sets)) == 0:
            snapshots.append(x)
    return np.array(snapshots)
