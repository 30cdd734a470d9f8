"""The robust fit: a reading may be a misreading, and the chance of that is marginalised over.

A residual's density is (1 - e) N(r; 0, 1) + e N(r; 0, K^2): good as stated, or, with chance e, a
misreading that is K times as far out. The likelihood is climbed by expectation and maximisation:
g_i, the chance that reading i is good, weighs its square in the next joint fit. It has several
modes, since a line follows its outlier; so it is climbed from all readings, from those left
when the worst one, two, ... are taken out in turn, and without each of the worst few. Each mode
is taken for a normal distribution by its curvature, and the answer is their mixture's mean and
covariance: a reading in doubt, or a choice between two stories, widens the intervals. Of many
readings no single one makes a mode, and the climb begins from all of them alone.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from ...model.errors import NotConverged
from .data import FitData, Floats
from .influence import leave_one_out
from .joint import Minimum, balance, minimise

BAD_CHANCE, BAD_WIDTH = 0.05, 12.0
_ROUNDS, _SETTLED, _MOST_TAKEN_OUT, _SHARE_TAKEN_OUT, _SUSPECTS = 80, 1e-6, 5, 0.3, 4
_MANY = 300  # readings


@dataclass(frozen=True)
class FitMode:
    """One mode of the likelihood: the weighted minimum and each reading's chance to be good.

    height: log of its share of the whole likelihood, but for a constant.
    """

    minimum: Minimum
    good: Floats
    height: float


def robust_minimum(data: FitData, plain: Minimum) -> FitMode:
    """Return the mixture of the modes found, about the best one; raises NotConverged."""
    modes: list[FitMode] = []
    for x, good in _starts(data, plain):
        mode = _climb(data, x, good)
        if all(np.abs(mode.minimum.x - s.minimum.x).max() > 1e-4 for s in modes):
            modes.append(mode)
    modes = [s for s in modes if math.isfinite(s.height)]
    if not modes:
        raise NotConverged(
            "the readings do not fix the unknowns of a robust fit; take method='joint', or more "
            "readings"
        )
    return _mixture(modes)


def _starts(data: FitData, plain: Minimum) -> list[tuple[Floats, Floats]]:
    everything = np.arange(len(data))
    if len(data) > _MANY:
        return [(plain.x, np.ones(len(data)))]
    sets = [np.delete(everything, k) for k in _worst_first(plain, len(data))[1:_SUSPECTS]]
    starts = [(plain.x, np.ones(len(data)))]
    keep, found = everything, plain
    for _ in range(min(_MOST_TAKEN_OUT, int(_SHARE_TAKEN_OUT * len(data)))):
        keep = np.delete(keep, _worst_first(found, len(keep))[0])
        found = minimise(data.picked(keep), found.x)
        starts.append((found.x, np.isin(everything, keep).astype(float)))
    return starts + [(plain.x, np.isin(everything, keep).astype(float)) for keep in sets]


def _worst_first(found: Minimum, count: int) -> list[int]:
    return np.argsort(leave_one_out(found, count).chi2).tolist()


def _mixture(modes: list[FitMode]) -> FitMode:
    """Return mean and covariance of all modes; what is no number stays the best one's."""
    best = max(modes, key=lambda s: s.height)
    share = np.exp([s.height - best.height for s in modes])
    share /= share.sum()
    xs = np.array([s.minimum.x for s in modes])
    mean = share @ xs
    spread = np.einsum("s,si,sj->ij", share, xs - mean, xs - mean)
    within = sum(
        part * np.linalg.inv(s.minimum.information) for part, s in zip(share, modes, strict=True)
    )
    minimum = replace(best.minimum, x=mean, information=np.linalg.inv(within + spread))
    return replace(best, minimum=minimum, good=share @ np.array([s.good for s in modes]))


def _climb(data: FitData, x: Floats, good: Floats) -> FitMode:
    for _ in range(_ROUNDS):
        x, before = minimise(data, x, _weights(good)).x, good
        good, _ = _chances(balance(x, data)[0])
        if np.abs(good - before).max() < _SETTLED:
            break
    found = minimise(data, x, _weights(good))
    good, log_densities = _chances(found.residuals[: len(data)])
    curved = _curved(found, good)
    priors = float(np.sum(found.residuals[len(data) :] ** 2)) / 2
    height = float(log_densities.sum()) - priors - half_log_determinant(curved.information)
    return FitMode(curved, good, height)


def half_log_determinant(information: Floats) -> float:
    """Return half the logarithm of its determinant; inf where it is not positive definite.

    A minimum far out, where a friction is 0 and a reading's whole error with it, has slopes of
    1e12 beside others of 1: rounding leaves no information there, and it is no mode.
    """
    scale = np.sqrt(np.diag(information))
    eigenvalues = np.linalg.eigvalsh(information / np.outer(scale, scale))
    if not eigenvalues[0] > len(scale) * np.finfo(float).eps:
        return math.inf
    return float(np.log(scale).sum() + np.log(eigenvalues).sum() / 2)


def _weights(good: Floats) -> Floats:
    return good + (1.0 - good) / BAD_WIDTH**2


def _chances(r: Floats) -> tuple[Floats, Floats]:
    """Return each reading's chance to be good, and the logarithm of its density but for a sum."""
    fine = math.log(1.0 - BAD_CHANCE) - 0.5 * r**2
    misread = math.log(BAD_CHANCE / BAD_WIDTH) - 0.5 * (r / BAD_WIDTH) ** 2
    both = np.logaddexp(fine, misread)
    return np.exp(fine - both), both


def _curved(found: Minimum, good: Floats) -> Minimum:
    """Return the minimum with the marginal likelihood's curvature as its information.

    -log p has the second derivative w - g (1 - g) r^2 (1 - 1/K^2)^2 in r. If what readings in doubt
    take away left it without a minimum, they count as nothing.
    """
    r, slopes = found.residuals[: len(good)], found.jacobian
    pull = good * (1.0 - good) * r**2 * (1.0 - BAD_WIDTH**-2) ** 2
    for curvature in (_weights(good) - pull, np.maximum(_weights(good) - pull, 0.0)):
        each = np.concatenate([curvature, np.ones(len(found.residuals) - len(good))])
        information = slopes.T @ (each[:, None] * slopes)
        if np.linalg.eigvalsh(information)[0] > 0.0:
            break
    return Minimum(found.x, found.residuals, slopes, found.chi2, information, found.parameters)
