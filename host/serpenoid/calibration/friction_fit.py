"""Friction of the whole snake fitted to a calibration session (Eqs. 58-62), with honest intervals.

On a treadmill inclined by gamma the snake holds its station where, over the whole body of weight
m g, with a share q of its links turned by lambda to the direction of the belt and the rest along,

    m g sin(gamma) = A v + B,
    A = (1 - q) ct + q (ct cos^2(lambda) + cn sin^2(lambda)),
    B = (1 - q) ft0 + q (ft0 cos(lambda) + fn0 sin(lambda)).

q = 1 is Eq. 60, the paper's zigzag; lambda = 0 is Eq. 58. A balanced bend of six links has q = 4/6.

All readings of a session, pushes along a floor among them (`floor.block`), make one
posterior (`fitting.posterior`): the fit's values are its mode, its intervals and covariance those
of draws. The paper's own fit is `fitting.paper_fit`.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace

import numpy as np

from ..base.checks import check_choice, check_kind
from ..base.errors import BadInput, NotConverged
from ..session.session import Session
from .alarms import with_alarms
from .fit_of_draws import fit_of_draws
from .fitting.identifiability import check_readings
from .fitting.paper_fit import errors, points, two_lines
from .fitting.posterior import Posterior
from .fitting.shared import FRICTIONS
from .fitting.stations import Stations
from .fitting.unknowns import Floats
from .floor.notes import check_floor
from .friction_result import LEVEL, METHODS, UNITS, FitDraws, FrictionFit, normal_draws, with_values
from .session_posterior import mode_of, posterior_of, usual_frictions


def fit_friction(
    session: Session,
    *,
    method: str = "joint",
    seed: int = 2005,
) -> FrictionFit:
    """Fit ct, cn, ft0 and fn0 to a session's kept readings: stations and pushes together.

    Parameters
    ----------
    session
        What was read.
    method
        "joint": errors in variables, all readings at once, no parameter below 0. Sigma is absolute,
        never rescaled by the scatter: chi2 tells whether the stated uncertainties hold.
        "naive": the paper's Eq. 61 and two straight lines, of stations alone; sigma is rescaled.
    seed
        Of the draws.

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
    if not session.on_floor:
        stations = Stations.of(session)
        check_readings(session, stations, 3 if method == "naive" else 2)
        if method == "naive":
            return _naive(session, stations)
    elif method == "naive":
        raise BadInput(
            f"{session.where}: method 'naive' is the paper's, of stations alone; pushes "
            "are fitted by 'joint'"
        )
    try:
        return _fitted(session, seed)
    except NotConverged as error:
        raise NotConverged(f"{session.where}: {error}; {_suspect(session)}") from error


def friction_points(session: Session, fit: FrictionFit) -> dict[str, tuple[Floats, Floats]]:
    """Return part -> (speeds, forces) of the kept readings, the points of Figs. 15 and 16.

    "straight": v_t and F_t by Eq. 58. "bent": v_n and F_n by Eq. 61, which takes the tangential
    friction as known, here from the fit. m/s and N, whole snake.
    """
    return points(Stations.of(session), np.array(list(fit.whole_snake.values())))


def voided_points(session: Session, fit: FrictionFit) -> dict[str, tuple[Floats, Floats]]:
    """Return part -> (speeds, forces) of the voided readings, as friction_points does."""
    voided = [
        replace(r, voided=False) for r in session.readings if r.voided and r.slip_speed_m_s > 0
    ]
    return friction_points(replace(session, readings=tuple(voided)), fit)


def point_errors(session: Session) -> dict[str, tuple[Floats, Floats]]:
    """Return part -> standard deviations of friction_points' speeds and forces, each alone."""
    return errors(Stations.of(session))


def _naive(session: Session, data: Stations) -> FrictionFit:
    from scipy.special import stdtrit

    values, covariance = two_lines(data)
    straight, bent = (int(which.sum()) for which in data.parts.values())
    freedom = np.array([straight, bent, straight, bent]) - 2
    widths = stdtrit(freedom, 0.5 + LEVEL / 2) * np.sqrt(np.diag(covariance))
    _check_signs(session, values)
    posterior = Posterior((data,))
    ends = np.maximum(np.column_stack([values - widths, values + widths]), 0.0)
    residuals = data.whole_residuals(posterior.by_name(posterior.start(values)[None]))[0][0]
    fit = with_values(
        session,
        values,
        covariance,
        ends,
        method="naive",
        sigma="rescaled",
        chi2=float(residuals @ residuals),
        dof=len(data) - len(FRICTIONS),
        residuals=tuple(residuals.tolist()),
        draws=FitDraws(FRICTIONS, normal_draws(values, covariance, ends)),
    )
    joint = posterior_of(session)
    return with_alarms(fit, session, joint.mode(joint.start(values)))


def _fitted(session: Session, seed: int) -> FrictionFit:
    """Return the fit of all readings, by their posterior."""
    mode = mode_of(session)
    if session.on_floor:
        check_floor(session, mode)
    return with_alarms(fit_of_draws(session, mode, mode.posterior.draws(mode, seed)), session, mode)


def _suspect(session: Session) -> str:
    """Name the reading without which the others agree best, where all together have no fit."""
    posterior = posterior_of(session)
    start = posterior.start(usual_frictions(session))
    numbers, left = posterior.numbers, dict[int, float]()
    for number in dict.fromkeys(numbers[numbers >= 0].tolist()):
        with suppress(NotConverged):
            left[number] = posterior.mode(start, np.where(numbers == number, 0.0, 1.0)).chi2
    if not left:
        return "look for a misread value"
    best = min(left, key=lambda number: left[number])
    return f"without reading {best} chi2 would be {left[best]:.1f}: look at that one first"


def _check_signs(session: Session, values: Floats) -> None:
    if values.min() < 0.0:
        name = FRICTIONS[int(values.argmin())]
        raise BadInput(
            f"{session.where}: the naive fit gives {name} = {values.min():.3g} {UNITS[name]}; it "
            "must be at least 0; use method='joint' or look for a misread value"
        )
