"""Maxima of a posterior density whose parameters have standard normal priors."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Residuals = Callable[[Floats], Floats]


class Maximum(NamedTuple):
    """A maximum of the posterior's density.

    x: (P,), the parameters. root: (P, P), root of the covariance of the normal approximation there.
    log_density: up to a constant of the posterior.
    """

    x: Floats
    root: Floats
    log_density: float

    @property
    def log_mass(self) -> float:
        """Return the logarithm of the probability about it, in the normal approximation."""
        return self.log_density + float(np.linalg.slogdet(self.root)[1])

    @property
    def determined(self) -> float:
        """Return the effective number of parameters that the readings determine."""
        return self.x.size - float(np.sum(self.root**2))


def log_density(residuals: Residuals, x: Floats) -> Floats:
    """Return the log density (K,) of the posterior at x (K, P), up to a constant."""
    return -0.5 * (np.sum(residuals(x) ** 2, axis=1) + np.sum(x**2, axis=1))


def maxima(
    residuals: Residuals,
    starts: Floats,
    *,
    step: float = 1e-3,
    same_distance: float = 0.05,
    log_density_range: float = 8.0,
) -> list[Maximum]:
    """Return the maxima that least squares reach from starts (S, P), the highest first.

    residuals: function of parameters (K, P) that returns differences (K, T) from the readings over
    their noise. step: step of central differences. same_distance: largest distance of results that
    are one maximum. Both are in sigmas of the prior. Maxima lower than the highest by more than
    log_density_range are left out.
    """
    from scipy.optimize import least_squares

    size = starts.shape[1]
    steps = step * np.eye(size)

    def with_prior(x: Floats) -> Floats:
        return np.append(residuals(x[None])[0], x)

    def jacobian(x: Floats) -> Floats:
        moved = residuals(np.vstack([x + steps, x - steps]))
        return np.vstack([(moved[:size] - moved[size:]).T / (2 * step), np.eye(size)])

    reached = [
        least_squares(with_prior, start, jac=jacobian, max_nfev=60)  # pyright: ignore[reportArgumentType] (SciPy's stubs)
        for start in starts
    ]
    reached.sort(key=lambda end: end.cost)
    distinct: list[Maximum] = []
    for end in reached:
        if end.cost > reached[0].cost + log_density_range:
            break
        if all(np.abs(end.x - maximum.x).max() > same_distance for maximum in distinct):
            root = np.linalg.cholesky(np.linalg.inv(end.jac.T @ end.jac))
            distinct.append(Maximum(end.x, root, -float(end.cost)))
    return distinct
