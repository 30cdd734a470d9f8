"""Fit as the paper does: a line through straight readings, and one, by Eq. 61, through bent."""

from __future__ import annotations

import numpy as np

from ..session.session import Session
from .bends import projections, resistance
from .parameters import FRICTIONS, Floats
from .result import FrictionFit
from .stations import Stations

Lines = dict[str, tuple[Floats, Floats]]


def friction_points(session: Session, fit: FrictionFit) -> Lines:
    """Return part -> (speeds, forces) of the kept readings, the points of Figs. 15 and 16.

    "straight": v_t and F_t by Eq. 58. "bent": v_n and F_n by Eq. 61, which takes the tangential
    friction as known, here from the fit. m/s and N, whole snake.
    """
    return points(Stations.from_session(session), fit.values)


def point_errors(session: Session) -> Lines:
    """Return part -> sigmas of the speeds and forces of friction_points."""
    data = Stations.from_session(session)
    by_speed, by_fn0 = _across(data)
    incline_sigma_rad = np.hypot(data.incline_sigma_rad, data.shared_sigma_rad)
    pull_n = data.weight_n * np.cos(data.incline_rad) * incline_sigma_rad
    force_n = np.hypot(pull_n, data.inertia_sigma_n) / by_fn0
    speed_m_s = data.speed_sigma_m_s * by_speed
    return {part: (speed_m_s[which], force_n[which]) for part, which in data.parts.items()}


def points(data: Stations, values: Floats) -> Lines:
    """Return part -> (speeds, forces): Eq. 58 straight, Eq. 61 bent; m/s and N, whole snake.

    If a share of the links is bent, Eq. 61 subtracts the friction of the straight ones and the
    tangential friction of the bent ones. values: the frictions, of which ct and ft0 are used.
    """
    pull_n = data.weight_n * np.sin(data.incline_rad) - data.inertia_n
    tangential = values * [name not in ("cn", "fn0") for name in FRICTIONS]
    viscous, dry = resistance(tangential, data.bends.share, data.lambda_rad)
    by_speed, by_fn0 = _across(data)
    force_n = np.where(data.bent, pull_n - viscous * data.slip_m_s - dry, pull_n) / by_fn0
    speed_m_s = data.slip_m_s * by_speed
    return {part: (speed_m_s[which], force_n[which]) for part, which in data.parts.items()}


def _across(data: Stations) -> tuple[Floats, Floats]:
    """Return factors (N,) of speed and force across the wheels, 1 for straight readings."""
    by_fn0 = projections(data.bends.share, data.lambda_rad)[3]
    return np.where(data.bent, np.sin(data.lambda_rad), 1.0), np.where(data.bent, by_fn0, 1.0)


def two_lines(data: Stations) -> tuple[Floats, Floats]:
    """Return the frictions (4,) by the paper's method, and their covariance (4, 4)."""
    values, covariance = np.zeros(len(FRICTIONS)), np.zeros((len(FRICTIONS),) * 2)
    for part, rows in (("straight", [0, 2]), ("bent", [1, 3])):
        values[rows], covariance[np.ix_(rows, rows)] = np.polyfit(
            *points(data, values)[part], 1, cov=True
        )
    return values, covariance
