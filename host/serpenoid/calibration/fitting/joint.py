"""The joint fit: errors in variables, all readings at once, as one small least-squares problem.

Unknown are the four parameters (and ct and ft0 backwards, where readings tell them), the true belt
speed v_i of every reading, an offset d_p of lambda for every posture p, set independently of the
others, the inclinometer's zero z, and how far straight links stand off their path (`shared`, where
the set-up states an error of its joints); all but the frictions and v_i have priors. The fit
minimises

    sum ((v_i' - v_i) / sv)^2 + ((gamma_i' - z - gamma(v_i)) / sg)^2 + |W (d / sd)|^2 + (z / sz)^2,

where W whitens what the bends' offsets have in common (`data.TOGETHER`).

Because the balance is linear in v_i, and m g sin(gamma) is over a reading's sg, every v_i can be
solved for by hand; what is left of a reading is one residual, the distance to the line:

    r_i = (m g sin(gamma_i' - z) - A v_i' - B) / s_i,
    s_i^2 = (m g cos(gamma_i' - z) sg)^2 + (A sv)^2,

and as many unknowns as there are frictions and nuisances. The full problem's covariance is kept:
eliminating the v_i by hand is the Schur complement that a solver would form. A robot that still
drifted when it was read has -m_e f of its track instead of A v (`tracks`), and the track's error in
s_i.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...model.errors import NotConverged
from .data import FitData, Floats, projections

_NOTHING = 1e-6  # of a friction's standard deviation


@dataclass(frozen=True)
class Minimum:
    """A least sum of squares: x the unknowns, the nuisances in sigmas of their priors.

    residuals: of the readings (not weighted), then of the priors. jacobian: d residuals / d x.
    chi2: their (weighted) sum of squares. information: the (weighted) normal matrix. parameters:
    how many of the unknowns are frictions, which come first.
    """

    x: Floats
    residuals: Floats
    jacobian: Floats
    chi2: float
    information: Floats
    parameters: int


def minimise(data: FitData, start: Floats, weights: Floats | None = None) -> Minimum:
    """Return the least sum of squares from a start, each reading's square weighted if told.

    No parameter below 0: the bounds are the physics. Raises NotConverged.
    """
    from scipy.optimize import least_squares

    unknowns = data.parameters + data.nuisances
    root = np.ones(len(data) + data.nuisances)
    if weights is not None:
        root[: len(data)] = np.sqrt(weights)
    low = np.full(unknowns, -np.inf)
    low[: data.parameters] = 0.0
    found = least_squares(
        lambda x: root * residuals(x, data),
        start,
        jac=lambda x: root[:, None] * jacobian(x, data),  # pyright: ignore[reportArgumentType]
        bounds=(low, np.inf),
        x_scale="jac",
        xtol=1e-12,
        ftol=1e-12,
        gtol=1e-12,
    )
    if not found.success:
        raise NotConverged(
            f"the joint fit stopped with {found.message!r} at chi2 = {2 * found.cost:.3g}; look "
            "for a misread value, or compare with method='naive'"
        )
    x = _at_limit(found.x, data)
    slopes = jacobian(x, data)
    return Minimum(
        x,
        residuals(x, data),
        slopes,
        2 * float(found.cost),
        slopes.T @ (root[:, None] ** 2 * slopes),
        data.parameters,
    )


def _at_limit(x: Floats, data: FitData) -> Floats:
    """Return the unknowns with frictions put to 0 that the solver left just inside their limit."""
    of = data.parameters
    scale = np.linalg.norm(jacobian(x, data)[:, :of], axis=0)  # over 1: a friction's own sigma
    x = x.copy()
    x[:of][x[:of] * scale < _NOTHING] = 0.0
    return x


def starting_point(values: Floats, data: FitData) -> Floats:
    """Return unknowns from all frictions; one below 0 starts from its mirror image, inside."""
    return np.concatenate([np.abs(values), np.zeros(data.nuisances)])


def residuals(x: Floats, data: FitData) -> Floats:
    """Return r_i of the readings, then those of the priors."""
    return np.concatenate([balance(x, data)[0], data.whitening @ x[data.parameters :]])


def whole_residuals(x: Floats, data: FitData) -> tuple[Floats, Floats]:
    """Return the readings' residuals with the shared rounding in them, and s_i's share in theirs.

    The residual is over all that a reading may err by, alone and in common.
    """
    bare = x.copy()
    bare[data.first_rounding : -1] = 0.0
    residual, spread, *_, per_incline = balance(bare, data)
    share = spread / np.hypot(spread, per_incline * _roundings(x, data)[1])
    return residual * share, share**2


def _offsets(x: Floats, data: FitData) -> tuple[Floats, Floats]:
    """Return each reading's offset of lambda and its prior's sigma, 0 where straight."""
    sigma = np.append(data.posture_sigma_rad, 0.0)  # -1, a straight reading's, picks the 0
    unit = np.append(x[data.first_posture : data.first_rounding], 0.0)
    return sigma[data.posture] * unit[data.posture], sigma[data.posture]


def _roundings(x: Floats, data: FitData) -> tuple[Floats, Floats]:
    """Return each reading's shared rounding error and its prior's sigma, 0 where it has none."""
    sigma = np.append(data.rounding_sigma_rad, 0.0)
    unit = np.append(x[data.first_rounding : -1], 0.0)
    return sigma[data.rounding] * unit[data.rounding], sigma[data.rounding]


def _astray(x: Floats, data: FitData) -> tuple[Floats, Floats]:
    """Return each reading's further share of fn0, by links off their path, and its sigma.

    Only links that are meant to be straight have one (`shared`).
    """
    unit = x[data.parameters] if data.straights else 0.0
    return data.astray_rad + data.astray_sigma_rad * unit, data.astray_sigma_rad


def balance(x: Floats, data: FitData) -> tuple[Floats, ...]:
    """Return r_i, s_i and what the Jacobian needs besides: see the head of this file."""
    (ct, ft0), cn, fn0 = data.along(x[: data.parameters]), x[1], x[3]
    angle = data.lambda_rad + _offsets(x, data)[0]
    by_ct, by_cn, by_ft0, by_fn0 = projections(data.bent_share, angle)
    by_fn0 = by_fn0 + _astray(x, data)[0]
    slope = ct * by_ct + cn * by_cn
    incline = data.incline_rad - data.zero_sigma_rad * x[-1] - _roundings(x, data)[0]
    drag_n, _ = data.tracks.drag(slope, data.slip_m_s)
    excess_n = data.weight_n * np.sin(incline) - drag_n - (ft0 * by_ft0 + fn0 * by_fn0)
    per_incline_n = data.weight_n * np.cos(incline)
    own_n = np.hypot(per_incline_n * data.incline_sigma_rad, data.inertia_sigma_n)
    spread_n = np.hypot(own_n, slope * data.speed_sigma_m_s)
    return excess_n / spread_n, spread_n, angle, slope, incline, per_incline_n


def jacobian(x: Floats, data: FitData) -> Floats:
    """Return d r / d x, (readings + nuisances, unknowns).

    dr = (d excess - r ds) / s with s ds = A sv^2 dA (+ the incline's part), so that a change of A
    acts at the fitted speed v_i = v_i' + r A sv^2 / s and one of B as it is.
    """
    (ct, ft0), cn, fn0 = data.along(x[: data.parameters]), x[1], x[3]
    r, spread, angle, slope, incline, per_incline = balance(x, data)
    cos, sin = np.cos(angle), np.sin(angle)
    by_ct, by_cn, by_ft0, by_fn0 = projections(data.bent_share, angle)
    astray, by_astray = _astray(x, data)
    by_fn0 = by_fn0 + astray
    speed = data.tracks.drag(slope, data.slip_m_s)[1] + r * slope * data.speed_sigma_m_s**2 / spread
    turned = 2 * (cn - ct) * sin * cos * speed + fn0 * cos - ft0 * sin
    by_offset = _offsets(x, data)[1] * data.bent_share * turned
    spread_by_zero = per_incline * data.incline_sigma_rad**2 * data.weight_n * np.sin(incline)
    by_incline = per_incline + r * spread_by_zero / spread
    out = np.zeros((len(data) + data.nuisances, len(x)))
    out[: len(data), :4] = np.column_stack([by_ct * speed, by_cn * speed, by_ft0, by_fn0])
    if data.ratchet:
        back = np.flatnonzero(data.back)
        for here, there in ((0, 4), (2, 5)):
            out[back, there], out[back, here] = out[back, here], 0.0
    if data.straights:
        out[: len(data), data.parameters] = fn0 * by_astray
    bent = np.flatnonzero(data.bent)
    out[bent, data.first_posture + data.posture[bent]] = by_offset[bent]
    rounded = np.flatnonzero(data.rounding >= 0)
    by_rounding = _roundings(x, data)[1] * by_incline
    out[rounded, data.first_rounding + data.rounding[rounded]] = by_rounding[rounded]
    out[: len(data), -1] = data.zero_sigma_rad * by_incline
    out[: len(data)] /= -spread[:, None]
    out[len(data) :, data.parameters :] = data.whitening
    return out
