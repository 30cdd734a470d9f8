"""The paper's own fit: a line through the straight readings, Eq. 61, a line through the bent."""

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
    """Return part -> standard deviations of friction_points' speeds and forces, each alone."""
    data = Stations.from_session(session)
    by_speed, by_fn0 = _across(data)
    incline_sigma_rad = np.hypot(data.incline_sigma_rad, data.shared_sigma_rad)
    pull_n = data.weight_n * np.cos(data.incline_rad) * incline_sigma_rad
    force_n = np.hypot(pull_n, data.inertia_sigma_n) / by_fn0
    speed_m_s = data.speed_sigma_m_s * by_speed
    return {part: (speed_m_s[which], force_n[which]) for part, which in data.parts.items()}


def points(data: Stations, values: Floats) -> Lines:
    """Return part -> (speeds, forces): Eq. 58 straight, Eq. 61 bent; m/s and N, whole snake.

    Eq. 61 with a share of the links bent: what the straight ones and the tangential friction of
    the bent ones take is taken off, and the rest is of the bent share.

    values: the frictions, of which ct and ft0 are taken.
    """
    pull_n = data.weight_n * np.sin(data.incline_rad) - data.inertia_n
    tangential = values * [name not in ("cn", "fn0") for name in FRICTIONS]
    viscous, dry = resistance(tangential, data.bends.share, data.lambda_rad)
    by_speed, by_fn0 = _across(data)
    force_n = np.where(data.bent, pull_n - viscous * data.slip_m_s - dry, pull_n) / by_fn0
    speed_m_s = data.slip_m_s * by_speed
    return {part: (speed_m_s[which], force_n[which]) for part, which in data.parts.items()}


def _across(data: Stations) -> tuple[Floats, Floats]:
    """Return by what a bent reading's speed, and its force, count across the wheels; else 1."""
    by_fn0 = projections(data.bends.share, data.lambda_rad)[3]
    return np.where(data.bent, np.sin(data.lambda_rad), 1.0), np.where(data.bent, by_fn0, 1.0)


def _line(x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """Return slope and intercept of the least-squares line, and their rescaled covariance."""
    design = np.column_stack([x, np.ones_like(x)])
    inverse = np.linalg.inv(design.T @ design)
    line = inverse @ design.T @ y
    scatter = y - design @ line
    return line, inverse * (scatter @ scatter) / max(len(x) - 2, 1)


def two_lines(data: Stations) -> tuple[Floats, Floats]:
    """Return the frictions as the paper found them, and their covariance."""
    values, covariance = np.zeros(len(FRICTIONS)), np.zeros((len(FRICTIONS),) * 2)
    along, across = [0, 2], [1, 3]
    values[along], covariance[np.ix_(along, along)] = _line(*points(data, values)["straight"])
    values[across], covariance[np.ix_(across, across)] = _line(*points(data, values)["bent"])
    return values, covariance
