"""Sines of one common rate, fitted to all joints: phi = c_0 + sum_k (a_k cos + b_k sin)(k w t).

Weighted least squares; the rate by Gauss and Newton's method.
"""

from __future__ import annotations

import numpy as np

from .vectors import Array

HARMONICS = 3


def basis(t_s: Array, omega: float, harmonics: int = HARMONICS) -> Array:
    """Return 1, cos w t, sin w t, cos 2 w t, ..., (samples, 1 + 2 harmonics)."""
    phase = np.outer(t_s, omega * np.arange(1, harmonics + 1))
    pairs = np.stack([np.cos(phase), np.sin(phase)], axis=-1).reshape(len(t_s), -1)
    return np.concatenate([np.ones((len(t_s), 1)), pairs], axis=1)


def basis_by_rate(t_s: Array, columns: Array) -> Array:
    """Return the derivative of a basis by the rate; columns: the basis."""
    slope = np.zeros_like(columns)
    lever = t_s[:, None] * np.arange(1, columns.shape[1] // 2 + 1)
    slope[:, 1::2], slope[:, 2::2] = -lever * columns[:, 2::2], lever * columns[:, 1::2]
    return slope


def weighted(columns: Array, values: Array, weight: Array) -> Array:
    """Return least-squares coefficients of each column of values with its weights.

    columns: a basis, and further columns after it; its overtones are weakly held at 0.
    """
    normal = columns.T @ (weight.T[..., None] * columns)
    hold = np.full(columns.shape[1], 1e-9)
    # A sample has weight 1. Overtones are determined even if part of a cycle is never seen.
    hold[3 : 1 + 2 * HARMONICS] = 2.5e-3
    right = columns.T @ (weight * values)
    return np.linalg.solve(normal + np.diag(hold), right.T[..., None])[..., 0].T


def fit_sines(t_s: Array, phi: Array, weight: Array, omega: float) -> tuple[float, Array]:
    """Return rate and coefficients (1 + 2 HARMONICS, joints) of all joints' common rate.

    phi, weight (samples, joints); omega: the rate to start from, rad/s.
    """
    for _ in range(12):
        columns = basis(t_s, omega)
        sines = weighted(columns, phi, weight)
        slope = basis_by_rate(t_s, columns) @ sines
        residual = phi - columns @ sines
        # The rate's own share of the slope: less what the coefficients can take up.
        clean = slope - columns @ weighted(columns, slope, weight)
        change = float(np.sum(weight * clean * residual) / np.sum(weight * clean * clean))
        omega += change
        if abs(change) < 1e-10 * omega:
            break
    return omega, weighted(basis(t_s, omega), phi, weight)
