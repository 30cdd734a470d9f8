"""The small valleys that kinks of dry friction make round a gait, from a fine table of shapes."""

from __future__ import annotations

import math

import numpy as np

from ..model.gait import Gait
from ..periodic.sweep import sweep
from .gait_cloud import Candidate, interpolated, valleys
from .shape_search import GaitShape, ShapeSearch

_SHAPES, _RATES = 13, 5  # of the table, each way
_WITHIN = 1.02  # of the cheapest in the table: what may turn out the best
_RTOL = 1e-3


def small_valleys(
    search: ShapeSearch, gait: Gait, speed_m_s: float, width: float, most: int
) -> list[Candidate]:
    """Return the cheapest shapes that no neighbour undercuts, within e^width of a gait's.

    The costs of the candidates are those of the table, from rates beside the right one. Limits of
    joint angle and servo speed are kept.
    """
    factors, limits = np.exp(np.linspace(-width, width, _SHAPES)), search.limits
    alpha = np.unique(np.minimum(gait.alpha_rad * factors, limits.joint_angle_rad))
    beta = np.unique(np.minimum(gait.beta_rad * factors, math.exp(search.bounds()[1][1])))
    omega = gait.omega_rad_s * np.exp(np.linspace(-2 * width, 2 * width, _RATES))
    found = sweep(
        search.robot, search.ground, alpha_rad=alpha, beta_rad=beta, omega_rad_s=omega,
        rtol=_RTOL, powers=search.cost != "power",
    )  # fmt: skip
    speed = np.where(found.converged, found.speed_m_s, np.nan)
    cost = np.where(found.converged, getattr(found, f"{search.cost}_w"), np.nan)
    rate, watts = interpolated(omega, speed, cost, speed_m_s)
    allowed = (alpha[:, None] * rate <= limits.servo_speed_rad_s) & (
        rate <= limits.omega_high_rad_s
    )
    price = np.where(allowed & np.isfinite(watts), watts, np.inf)
    return [
        Candidate(watts, GaitShape.of(float(alpha[i]), float(beta[j])), float(rate[i, j]))
        for watts, (i, j) in valleys(price, most)
        if watts <= _WITHIN * price.min()
    ]
