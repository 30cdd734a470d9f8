"""A fine table of shapes round a gait: on dry ground, kinks make small valleys in a large one."""

from __future__ import annotations

import math

import numpy as np

from ..model.gait import Gait
from .gait_table import Candidate, GaitTable
from .shape_search import ShapeSearch

_SHAPES, _RATES = 13, 5  # of the table, each way; steps of width / 6
_WITHIN = 1.02  # of the cheapest: what lines between rates may hide
_RTOL = 1e-3


def refined_valleys(
    search: ShapeSearch, gait: Gait, speed_m_s: float, width: float, most: int
) -> list[Candidate]:
    """Return the cheapest shapes that no neighbour undercuts, within e^width of a gait's.

    The costs are those of the table, from the exact model and rates beside the right one.
    """
    factors = np.exp(np.linspace(-width, width, _SHAPES))
    alpha = np.unique(np.minimum(gait.alpha_rad * factors, search.limits.joint_angle_rad))
    beta = np.unique(np.minimum(gait.beta_rad * factors, math.exp(search.bounds()[1][1])))
    table = GaitTable(
        search.robot, search.ground, search.cost, search.limits, alpha[:, None], beta, _RTOL
    )
    table.add_rates(gait.omega_rad_s * np.exp(np.linspace(-2 * width, 2 * width, _RATES)))
    return table.candidates(speed_m_s, most, _WITHIN)
