"""The paper's own fit: a line through the straight readings, Eq. 61, a line through the bent."""

from __future__ import annotations

import numpy as np

from .data import FitData, Floats


def points(data: FitData, ct: float, ft0: float) -> dict[str, tuple[Floats, Floats]]:
    """Return part -> (speeds, forces): Eq. 58 straight, Eq. 61 bent; m/s and N, whole snake."""
    pull_n = data.weight_n * np.sin(data.incline_rad)
    b, cos, sin = data.bent, np.cos(data.lambda_rad), np.sin(data.lambda_rad)
    along_n = (ct * data.slip_m_s * cos + ft0) * cos
    across_n = (pull_n[b] - along_n[b]) / sin[b]
    return {
        "straight": (data.slip_m_s[~b], pull_n[~b]),
        "bent": (data.slip_m_s[b] * sin[b], across_n),
    }


def _line(x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """Return slope and intercept of the least-squares line, and their rescaled covariance."""
    design = np.column_stack([x, np.ones_like(x)])
    inverse = np.linalg.inv(design.T @ design)
    line = inverse @ design.T @ y
    scatter = y - design @ line
    return line, inverse * (scatter @ scatter) / max(len(x) - 2, 1)


def two_lines(data: FitData) -> tuple[Floats, Floats]:
    """Return (ct, cn, ft0, fn0) as the paper found them, and their (4, 4) covariance."""
    (ct, ft0), straight_cov = _line(*points(data, 0.0, 0.0)["straight"])
    (cn, fn0), bent_cov = _line(*points(data, ct, ft0)["bent"])
    covariance = np.zeros((4, 4))
    covariance[0::2, 0::2], covariance[1::2, 1::2] = straight_cov, bent_cov
    return np.array([ct, cn, ft0, fn0]), covariance
