"""Intervals from the likelihood's own shape: how far chi2 may rise, all other unknowns following.

A normal distribution by the covariance misses the skew of cn: at a small bend it goes as 1 / sin^2
of an uncertain angle, and the slope of a line is uncertain too. The ends of the interval of unknown
k are where it is extreme among all x with chi2(x) = least + rise. With residuals r and Jacobian J
at a point, chi2 at x + d is about |r + J d|^2; x_k + d_k is extreme on the wanted level for

    d = -C J' r + t C e_k,    C = (J' J)^-1,    t = +- sqrt((level - |r|^2 + r' J C J' r) / C_kk),

and this is repeated from there until it stays: a few small solves, no fit within a search.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from .data import FitData, Floats
from .joint import Minimum, jacobian, residuals

_ROUNDS, _SETTLED, _HALVINGS = 60, 1e-6, 16
_NOTHING = 1e-4  # of a friction, or of its standard deviation: an interval's low end is then 0
_AT_LEVEL = 2.0  # times the rise of chi2 asked for: an end may have that, with others at 0


def quantiles(data: FitData, found: Minimum, level: float) -> Floats:
    """Return (P,): how many sigmas either side hold the level, with rounding's own distribution.

    To first order an estimate errs by a normal part and by -C_kr R^-1 u of the shared rounding
    errors u, R their correlation: a mixture over the draws of u.
    """
    from scipy.special import ndtr, ndtri

    if not len(data.rounding_sigma_rad):
        return np.full(data.parameters, ndtri(0.5 + level / 2))
    covariance = np.linalg.inv(found.information)
    sigma = np.sqrt(np.diag(covariance))[: data.parameters]
    shared = slice(len(found.x) - 1 - len(data.rounding_sigma_rad), -1)
    gain = covariance[: data.parameters, shared] @ np.linalg.inv(data.rounding_correlation)
    by_rounding = gain @ data.rounding_draws.T / sigma[:, None]
    rest = np.sqrt(np.maximum(1.0 - np.mean(by_rounding**2, axis=1), 1e-6))[:, None]
    low, high = (
        np.zeros((data.parameters, 1)),
        np.full((data.parameters, 1), 2 * ndtri(0.5 + level / 2)),
    )
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        ends = [ndtr((sign * middle - by_rounding) / rest) for sign in (1.0, -1.0)]
        held = np.mean(ends[0] - ends[1], axis=1, keepdims=True)
        low, high = np.where(held < level, middle, low), np.where(held < level, high, middle)
    return ((low + high) / 2).ravel()


class Terms(Protocol):
    """A sum of squares: the residuals, their Jacobian, and how many unknowns are frictions."""

    @property
    def parameters(self) -> int:
        """Return how many of the unknowns are frictions, which come first."""
        ...

    def residuals(self, x: Floats) -> Floats:
        """Return the residuals."""
        ...

    def jacobian(self, x: Floats) -> Floats:
        """Return d residuals / d x."""
        ...


@dataclass(frozen=True)
class StationTerms:
    """The terms of stations alone (`joint`)."""

    data: FitData

    @property
    def parameters(self) -> int:
        """Return how many frictions there are."""
        return self.data.parameters

    def residuals(self, x: Floats) -> Floats:
        """Return those of the readings, then of the priors."""
        return residuals(x, self.data)

    def jacobian(self, x: Floats) -> Floats:
        """Return d residuals / d x."""
        return jacobian(x, self.data)


def intervals(data: Terms, found: Minimum, quantile: Floats) -> Floats:
    """Return (P, 2): lowest and highest of each friction with chi2 at most quantile^2 above least.

    None below 0. Where the search does not settle, the covariance's own interval stands.
    """
    sigma = np.sqrt(np.diag(np.linalg.inv(found.information)))
    out = np.empty((data.parameters, 2))
    for k in range(data.parameters):
        for side, sign in enumerate((-1.0, 1.0)):
            end = _extreme(data, found, k, sign, found.chi2 + quantile[k] ** 2)
            plain = found.x[k] + sign * quantile[k] * sigma[k]
            out[k, side] = max(plain if end is None else end, 0.0)
    return out


def _extreme(data: Terms, found: Minimum, k: int, sign: float, level: float) -> float | None:
    x = found.x
    for _ in range(_ROUNDS):
        r, slopes = data.residuals(x), data.jacobian(x)
        try:
            covariance = np.linalg.inv(slopes.T @ slopes)
        except np.linalg.LinAlgError:
            break
        if not (np.diag(covariance) > 0.0).all():  # singular but for rounding
            break
        pull = slopes.T @ r
        room = level - float(r @ r) + float(pull @ covariance @ pull)
        reach = sign * np.sqrt(max(room, 0.0) / covariance[k, k])
        following = x - covariance @ pull + reach * covariance[:, k]
        if sign < 0.0 and following[k] <= 0.0 and x[k] <= 0.0:
            return 0.0
        following[: data.parameters] = np.maximum(following[: data.parameters], 0.0)
        # Halfway to 0, or half as far again, at most: the map is linear only nearby.
        low, high = 0.5 * x[: data.parameters], 1.5 * x[: data.parameters]
        tight = x[: data.parameters] > 1e-9
        near = np.clip(
            following[: data.parameters], np.where(tight, low, 0.0), np.where(tight, high, np.inf)
        )
        following[: data.parameters] = near
        moved = np.abs(following - x) / np.sqrt(np.diag(covariance))
        x = following
        if not np.isfinite(x).all():
            break
        if sign < 0.0 and x[k] <= _NOTHING * max(found.x[k], np.sqrt(covariance[k, k])):
            return 0.0
        if moved.max() < _SETTLED:
            chi2 = float(np.sum(data.residuals(x) ** 2))
            # far off the level it is no end: the search ran out along a flat valley
            return float(x[k]) if chi2 - found.chi2 < _AT_LEVEL * (level - found.chi2) else None
    return None
