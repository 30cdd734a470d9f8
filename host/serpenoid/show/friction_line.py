"""The fitted line of friction over speed, with its error, for figures."""

from __future__ import annotations

import numpy as np

from ..calibration.friction_result import FrictionFit

# Of each part of the readings, the parameters of its line.
LINES = {"straight": ("ct", "ft0"), "bent": ("cn", "fn0")}


def line(fit: FrictionFit, part: str, speeds_m_s: np.ndarray) -> np.ndarray:
    """Return a part's line from rest to beyond the speeds: rows of v, F, 0, sigma of F."""
    order = list(fit.whole_snake)
    picked = [order.index(name) for name in LINES[part]]
    v = np.linspace(0, 1.08 * float(speeds_m_s.max()), 60)
    terms = np.column_stack([v, np.ones_like(v)])
    force = terms @ [fit.parameters[name].value for name in LINES[part]]
    variance = np.sum(terms @ fit.covariance[np.ix_(picked, picked)] * terms, axis=1)
    return np.column_stack([v, force, np.zeros_like(v), np.sqrt(variance)])
