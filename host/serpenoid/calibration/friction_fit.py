"""Friction of the whole snake fitted to a calibration session (Eqs. 58-62), with honest intervals.

On a treadmill inclined by gamma the snake holds its station where, over the whole body of weight
m g, with a share q of its links turned by lambda to the direction of the belt and the rest along,

    m g sin(gamma) = A v + B,
    A = (1 - q) ct + q (ct cos^2(lambda) + cn sin^2(lambda)),
    B = (1 - q) ft0 + q (ft0 cos(lambda) + fn0 sin(lambda)).

q = 1 is Eq. 60, the paper's zigzag; lambda = 0 is Eq. 58. A balanced bend of six links has q = 4/6.

The room `fitting` holds the three ways to find ct, cn, ft0, fn0 from readings of it: `joint`,
`robust` (joint, with misreadings marginalised over) and `naive`, the paper's own.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from ..model.checks import check_choice, check_kind
from ..model.drives import ServoKind
from ..model.errors import BadInput, NotConverged
from .alarms import parts, with_alarms
from .crawls.result import fit_crawls
from .fitting.data import FitData, Floats, projections
from .fitting.identifiability import bend_note, check_readings
from .fitting.influence import BOTH_WAYS, Influence, influences
from .fitting.joint import minimise, starting_point, whole_residuals
from .fitting.joint import residuals as residuals_at
from .fitting.paper_fit import points, two_lines
from .fitting.profile import StationTerms, intervals, quantiles
from .fitting.robust import FitMode, half_log_determinant, robust_minimum
from .fitting.shared import shared_covariance, widened
from .floor.result import fit_floor
from .friction_result import (
    LEVEL,
    UNITS,
    Estimate,
    FrictionFit,
    WholeSnake,
    ground_of,
    notes_on,
)
from .session import Session

METHODS = ("joint", "robust", "naive")


def fit_friction(
    session: Session,
    *,
    method: str = "joint",
    crawls: bool = False,
    servo: ServoKind | None = None,
    seed: int = 2005,
) -> FrictionFit:
    """Fit ct, cn, ft0 and fn0 to a session's kept readings: stations, pushes and slides together.

    Readings taken facing up the belt tell ct and ft0 backwards: the ground is then a ratchet.

    Parameters
    ----------
    session
        What was read.
    method
        "joint": errors in variables, all readings at once, no parameter below 0. Sigma is absolute,
        never rescaled by the scatter: chi2 tells whether the stated uncertainties hold. "robust":
        the same, but any reading may be a misreading. Those in doubt count less, and are named.
        "naive": the paper's Eq. 61 and two straight lines; sigma is rescaled.
    crawls
        Fit the session's gait runs and films, too, or alone where there is nothing else. By draws,
        since what they tell is no normal cloud. `compare` tests predictions by crawls, so they are
        left out unless asked for.
    servo
        The kind that moved the joints in those crawls; None: they followed the gait.
    seed
        Of the draws, where crawls are fitted.

    Returns
    -------
    FrictionFit
        Values, intervals and notes.

    Raises
    ------
    BadInput
        The readings leave a friction open. It names the friction and the reading that would tell
        it: fewer than two straight or two bent ones (three if naive), speeds too close to each
        other, or a bend that its uncertainty could undo.

    Examples
    --------
    >>> session = sn.load_session("calibration_data/nirakh-2005")
    >>> fit = sn.fit_friction(session)
    >>> round(fit.parameters["ct"].value, 3)
    0.084
    """
    check_kind("session", session, Session)
    check_choice("method", method, METHODS)
    if crawls:
        if method != "joint":
            raise BadInput(f"crawls are fitted by method 'joint', not {method!r}")
        servo = servo and session.setup.driving(servo)
        return fit_crawls(session, _beside_crawls(session), servo, seed)
    if session.on_floor:
        return _on_floor(session, method)
    data = FitData.of(session)
    check_readings(session, data, 3 if method == "naive" else 2)
    if method == "naive":
        return _naive(session, data)
    try:
        return _joint(session, data, method)
    except NotConverged as error:
        raise NotConverged(f"{session.where}: {error}") from error


def _beside_crawls(session: Session) -> FrictionFit | None:
    """Return the fit of all other readings; None where there are none, or pushes that leave some
    frictions open, such as those by tape and watch.
    """
    if not session.fitted:
        return None
    try:
        return fit_friction(session)
    except (BadInput, NotConverged):
        if session.on_floor and not session.kept:
            return None
        raise


def _on_floor(session: Session, method: str) -> FrictionFit:
    if method != "joint":
        raise BadInput(
            f"{session.where}: pushes and slides are fitted by method 'joint' alone, not {method!r}"
            "; its table of influence names a push that does not fit the others"
        )
    return fit_floor(session)


def friction_points(session: Session, fit: FrictionFit) -> dict[str, tuple[Floats, Floats]]:
    """Return part -> (speeds, forces) of the kept readings, the points of Figs. 15 and 16.

    "straight": v_t and F_t by Eq. 58. "bent": v_n and F_n by Eq. 61, which takes the tangential
    friction as known, here from the fit. m/s and N, whole snake.
    """
    return points(FitData.of(session), np.array(list(fit.whole_snake.values())))


def voided_points(session: Session, fit: FrictionFit) -> dict[str, tuple[Floats, Floats]]:
    """Return part -> (speeds, forces) of the voided readings, as friction_points does."""
    voided = [
        replace(r, voided=False) for r in session.readings if r.voided and r.slip_speed_m_s > 0
    ]
    return friction_points(replace(session, readings=tuple(voided)), fit)


def point_errors(session: Session) -> dict[str, tuple[Floats, Floats]]:
    """Return part -> standard deviations of friction_points' speeds and forces, each alone."""
    data = FitData.of(session).alone
    force = np.hypot(
        data.weight_n * np.cos(data.incline_rad) * data.incline_sigma_rad, data.inertia_sigma_n
    )
    b, across = data.bent, np.sin(data.lambda_rad[data.bent])
    by_fn0 = projections(data.bent_share, data.lambda_rad)[3][b]
    ahead, back = ~b & ~data.back, ~b & data.back
    return {
        "straight": (data.speed_sigma_m_s[ahead], force[ahead]),
        "back": (data.speed_sigma_m_s[back], force[back]),
        "bent": (data.speed_sigma_m_s[b] * across, force[b] / by_fn0),
    }


@dataclass(frozen=True)
class _Raw:
    """What a method found: values, covariance, (P, 2) intervals, in BOTH_WAYS' order."""

    values: Floats
    covariance: Floats
    intervals: Floats
    residuals: Floats
    chi2: float
    good: Floats
    nuisances: dict[str, Estimate]
    influence: tuple[Influence, ...] = ()


def _naive(session: Session, data: FitData) -> FrictionFit:
    from scipy.special import stdtrit

    values, covariance = two_lines(data)
    straight, back, bent = parts(data)
    freedom = np.array([straight, bent, straight, bent, back, back])[: data.parameters] - 2
    widths = stdtrit(freedom, 0.5 + LEVEL / 2) * np.sqrt(np.diag(covariance))
    _check_signs(session, values)
    data = data.alone
    residuals = residuals_at(starting_point(values, data), data)[: len(data)]
    chi2 = float(residuals @ residuals)
    raw = _Raw(values, covariance, _about(values, widths), residuals, chi2, np.ones(len(data)), {})
    fit = _result(session, data, raw, "naive")
    return with_alarms(fit, session, data)


def _joint(session: Session, data: FitData, method: str) -> FrictionFit:
    plain = minimise(data, starting_point(two_lines(data)[0], data))
    if method == "joint":
        raw = _raw(session, data, FitMode(plain, np.ones(len(data)), 0.0))
        return with_alarms(_result(session, data, raw, method), session, data, plain)
    fit = _result(session, data, _raw(session, data, robust_minimum(data, plain)), method)
    return with_alarms(fit, session, data, plain)


def _raw(session: Session, data: FitData, found: FitMode) -> _Raw:
    from scipy.special import ndtri

    x, count = found.minimum.x, len(data)
    residuals = found.minimum.residuals[:count]
    covariance = _covariance(found.minimum.information, session, residuals)
    sigmas = np.sqrt(np.diag(covariance))
    whole, share = whole_residuals(x, data)
    quantile = float(ndtri(0.5 + LEVEL / 2))
    if found.good.min() == 1.0:
        ends = intervals(StationTerms(data), found.minimum, quantiles(data, found.minimum, LEVEL))
    else:
        ends = _about(x[: data.parameters], quantile * sigmas[: data.parameters])
    counted = found.good > 0.5
    values = x[: data.parameters]
    shared = shared_covariance(values, data.belt_sigma, data.mass_sigma)
    ends = widened(ends, values, np.sqrt(np.diag(shared)), quantile)
    own = covariance[: data.parameters, : data.parameters] + shared
    return _Raw(
        values=values,
        covariance=_beside_limits(own, values, ends, quantile),
        intervals=ends,
        residuals=whole,
        chi2=float(np.sum(residuals[counted] ** 2) + np.sum(found.minimum.residuals[count:] ** 2)),
        good=found.good,
        nuisances=_nuisances(data, x, sigmas),
        influence=influences(found.minimum, [r.number for r in session.kept], share),
    )


def _covariance(information: Floats, session: Session, residuals: Floats) -> Floats:
    """Return its inverse; raises NotConverged where rounding errors are all that is left of it."""
    if not math.isfinite(half_log_determinant(information)):
        worst = session.kept[int(np.argmax(np.abs(residuals)))].number
        raise NotConverged(
            "the readings contradict each other so far that no friction is told; reading "
            f"{worst} is furthest off: look at it first"
        )
    return np.asarray(np.linalg.inv(information), dtype=np.float64)


def _beside_limits(covariance: Floats, values: Floats, ends: Floats, quantile: float) -> Floats:
    """Return a covariance that agrees with intervals which end at the limit of 0.

    The curvature there is that of a friction which could be negative; the interval knows better.
    """
    sigma = np.sqrt(np.diag(covariance))
    above = (ends[:, 1] - values) / quantile
    share = np.where(ends[:, 0] > 0.0, 1.0, np.minimum(above / sigma, 1.0))
    return covariance * np.outer(share, share)


def _about(values: Floats, widths: Floats) -> Floats:
    return np.maximum(np.column_stack([values - widths, values + widths]), 0.0)


def _nuisances(data: FitData, x: Floats, sigmas: Floats) -> dict[str, Estimate]:
    """Return the offsets by the posture's name and the zero; they count in sigmas of the prior."""
    shown = np.degrees(data.posture_lambda_rad)
    names: list[str] = []
    for name in (f"lambda_offset_rad_at_{degrees:.4g}_deg" for degrees in shown):
        again = sum(n == name or n.startswith(name + "_again") for n in names)
        names.append(name + (f"_again_{again}" if again else ""))
    units = np.append(data.posture_sigma_rad, data.zero_sigma_rad.max())
    told = [*range(data.first_posture, data.first_rounding), -1]
    values, widths = units * x[told], units * sigmas[told]
    estimates = map(Estimate, values.tolist(), widths.tolist())
    return dict(zip([*names, "incline_zero_rad"], estimates, strict=True))


def _check_signs(session: Session, values: Floats) -> None:
    if values.min() < 0.0:
        name = BOTH_WAYS[int(values.argmin())]
        raise BadInput(
            f"{session.where}: the naive fit gives {name} = {values.min():.3g} {UNITS[name]}; it "
            "must be at least 0; use method='joint' or look for a misread value"
        )


def _result(session: Session, data: FitData, raw: _Raw, method: str) -> FrictionFit:
    covariance = raw.covariance.copy()
    covariance.flags.writeable = False
    values, sigmas = raw.values.tolist(), np.sqrt(np.diag(covariance)).tolist()
    ends, names = map(tuple, raw.intervals.tolist()), BOTH_WAYS[: data.parameters]
    numbers = [r.number for r in session.kept]
    fit = FrictionFit(
        method=method,
        sigma="rescaled" if method == "naive" else "absolute",
        parameters=WholeSnake(dict(zip(names, map(Estimate, values, sigmas), strict=True))),
        intervals=WholeSnake(dict(zip(names, ends, strict=True))),
        covariance=covariance,
        robot=session.setup.robot,
        ground=ground_of(session.setup.robot.links, values),
        chi2=raw.chi2,
        dof=int(np.sum(raw.good > 0.5)) - data.parameters,
        nuisances=MappingProxyType(raw.nuisances),
        residuals=tuple(raw.residuals.tolist()),
        outliers=tuple(n for n, good in zip(numbers, raw.good, strict=True) if good <= 0.5),
        influence=raw.influence,
        notes=(),
        session_name=session.setup.name,
        session_sha256=session.sha256,
    )
    return replace(fit, notes=(*notes_on(fit, session), *bend_note(data)))
