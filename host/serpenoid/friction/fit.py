"""Fit the friction of the whole snake to a calibration session (Eqs. 58-62), with intervals.

On a treadmill inclined by gamma the snake holds its station where, over the whole body of weight
m g, with a share q of its links turned by lambda to the direction of the belt and the rest along,

    m g sin(gamma) = A v + B,
    A = (1 - q) ct + q (ct cos^2(lambda) + cn sin^2(lambda)),
    B = (1 - q) ft0 + q (ft0 cos(lambda) + fn0 sin(lambda)).

q = 1 is Eq. 60, the paper's zigzag; lambda = 0 is Eq. 58. A balanced bend of six links has q = 4/6.

All readings of a session, with pushes along a floor, give one posterior. The fit's values are its
MAP estimate; its intervals and covariance come from samples. The paper's own fit is in `paper_fit`.

The law m g sin(gamma) = A v + B still holds if mass and all frictions are multiplied by one factor,
and if the belt's speed is multiplied by a factor and ct and cn divided by it. So stations cannot
determine the errors of mass and belt speed, which multiply the samples instead.
"""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from types import MappingProxyType
from typing import Any

import numpy as np

from ..base.checks import check_choice, check_kind
from ..base.errors import BadInput, NotConverged
from ..session.session import Session
from .bends import COMMON_ERROR, STRAIGHTNESS
from .notes import (
    READING,
    alarms_of,
    check_floor,
    check_poses,
    check_readings,
    notes_on,
    suspects,
)
from .parameters import BELT, FRICTIONS, ROUNDING, Floats, Rows
from .posterior import COUNT, MapEstimate, Posterior, Samples
from .result import (
    KEPT_SAMPLES,
    LEVEL,
    METHODS,
    UNITS,
    Estimate,
    FrictionFit,
    Influence,
    narrowest,
    spread_samples,
)

USUAL, USUAL_N = (0.084, 1.2, 0.14, 0.27), 4.4484  # Friction of the 2005 robot, and its weight.
VISCOUS = np.array([1.0, 1.0, 0.0, 0.0])  # 1 for frictions that depend on the belt's scale.


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
        The session with the readings.
    method
        "joint": all readings at once, with errors in variables, and no parameter below 0. Sigma is
        absolute; chi2 shows whether the stated uncertainties hold. "naive": the paper's Eq. 61 and
        two straight lines through stations; sigma is rescaled by the scatter.
    seed
        Seed of the samples.

    Returns
    -------
    FrictionFit
        Values, intervals and notes.

    Raises
    ------
    BadInput
        If the readings do not determine a friction: there are fewer than two straight or two bent
        ones (three if naive), their speeds are too close to each other, or the bend is too small
        for its uncertainty. The message names the friction and the reading to take.

    Examples
    --------
    >>> session = sn.load_session("calibration_data/nirakh-2005")
    >>> fit = sn.fit_friction(session)
    >>> round(fit.parameters["ct"].value, 3)
    0.084
    """
    check_kind("session", session, Session)
    check_choice("method", method, METHODS)
    naive = method == "naive"
    if session.on_floor and naive:
        raise BadInput(
            f"{session.where}: method 'naive' is the paper's, of stations alone; pushes "
            "are fitted by 'joint'"
        )
    if session.on_floor:
        check_poses(session)
    else:
        from .stations import Stations

        check_readings(session, Stations.from_session(session), 3 if naive else 2)
    try:
        estimate = map_estimate(session)
        if session.on_floor:
            check_floor(session, estimate)
        fit = _naive(session) if naive else _joint(session, estimate, seed)
    except NotConverged as error:
        more = ", or take more pushes, straight and bent, both ways" * session.on_floor
        raise NotConverged(f"{session.where}: {error}; look for a misread value{more}") from error
    refits = {words: _refit(estimate, rows) for words, rows in suspects(session, estimate).items()}
    if not naive:
        fit = replace(fit, influence=_influences(fit, refits))
    alarms = alarms_of(fit, estimate, refits)
    return replace(fit, alarms=alarms, notes=(*alarms, *notes_on(fit, session)))


def posterior_of(session: Session, slipping: bool = True) -> Posterior:
    """Return the posterior of a session's kept stations and pushes.

    slipping: whether the model lets robots without a straight link slip sideways.
    """
    kinds: list[Any] = []
    roundings_rad = np.empty((1, 0))
    if session.kept_stations:
        from .stations import Stations

        stations = Stations.from_session(session)
        kinds.append(stations)
        roundings_rad = stations.rounding_samples
    if session.on_floor:
        from .pushes import Pushes

        kinds.append(Pushes.from_session(session, slipping))
    return Posterior(tuple(kinds), roundings_rad)


def map_estimate(session: Session) -> MapEstimate:
    """Return the MAP estimate of a session's readings; raises NotConverged.

    The search starts from the 2005 robot's friction, or, if robots may slip sideways, from the
    estimate without slip.
    """
    posterior = posterior_of(session)
    start = posterior.start(np.array(USUAL) * session.setup.weight_n / USUAL_N)
    if any(kind.slips for kind in posterior.kinds):
        start = posterior_of(session, slipping=False).estimate(start).x
    return posterior.estimate(start)


def covariance_after(session: Session, estimate: MapEstimate) -> Floats:
    """Return the covariance (4, 4) of the frictions given a session's readings, linearised.

    It contains the errors of belt and mass. estimate: the point of the linearisation, from all or
    some of the readings; parameters that it lacks are at their prior mean.
    """
    posterior = posterior_of(session)
    coordinates = dict(zip(estimate.posterior.names, estimate.x.tolist(), strict=True))
    x = np.array([coordinates.get(name, 0.0) for name in posterior.names])
    covariance = posterior.linear_about(x).estimate_at(x).covariance[:COUNT, :COUNT]
    belt, mass = _scale_sigmas(session, posterior)
    frictions, viscous = x[:COUNT], x[:COUNT] * VISCOUS
    scales = mass**2 * np.outer(frictions, frictions) + belt**2 * np.outer(viscous, viscous)
    return np.asarray(covariance + scales)


def _refit(estimate: MapEstimate, omitted: Rows) -> MapEstimate | None:
    """Return the estimate without some residuals; None if the others do not determine it."""
    with suppress(NotConverged):
        return estimate.without(omitted)
    return None


def _scale_sigmas(session: Session, posterior: Posterior) -> tuple[float, float]:
    """Return the relative sigmas of belt and mass, where they are not parameters of the fit."""
    belt = session.belt_scale[1] if session.kept_stations and BELT not in posterior.names else 0.0
    return belt, session.setup.mass_sigma


def _scaled(session: Session, posterior: Posterior, samples: Samples, seed: int) -> Samples:
    """Return the samples with log-normal errors of belt and mass multiplied into the frictions."""
    belt, mass = np.random.default_rng([seed, 2]).normal(size=(2, len(samples.x), 1))
    belt_sigma, mass_sigma = _scale_sigmas(session, posterior)
    factors = np.exp(mass_sigma * mass - belt_sigma * VISCOUS * belt)
    x = np.column_stack([samples.x[:, :COUNT] * factors, samples.x[:, COUNT:]])
    return replace(samples, x=x)


def _joint(session: Session, estimate: MapEstimate, seed: int) -> FrictionFit:
    """Return the fit of all readings, without influences and notes."""
    posterior, values = estimate.posterior, estimate.x[:COUNT]
    samples = _scaled(session, posterior, posterior.samples(estimate, seed), seed)
    frictions = samples.x[:, :COUNT]
    ends = np.array(
        [narrowest(frictions[:, k], samples.weight_for(k), values[k]) for k in range(COUNT)]
    )
    covariance = np.cov(frictions.T, aweights=samples.unlimited, ddof=0)
    shown = [kind.sizes(estimate.values) for kind in posterior.kinds]
    return FrictionFit(
        "joint",
        session.setup.robot,
        values,
        _beside_limits(covariance, values, ends),
        ends,
        spread_samples(frictions, samples.weight, seed),
        chi2=estimate.chi2,
        dof=int(np.sum(posterior.numbers >= 0)) - COUNT,
        nuisances=_nuisances(estimate, samples),
        residuals=tuple(np.concatenate(shown).tolist()),
        session_name=session.setup.name,
        session_sha256=session.sha256,
    )


def _beside_limits(covariance: Floats, values: Floats, ends: Floats) -> Floats:
    """Return the covariance, reduced for frictions whose intervals end at the limit of 0.

    Their sigma is at most such that value + 1.96 sigma is the interval's upper end.
    """
    sigma = np.sqrt(np.diag(covariance))
    above = (ends[:, 1] - values) / 1.96
    share = np.where(ends[:, 0] > 0.0, 1.0, np.minimum(above / np.maximum(sigma, 1e-300), 1.0))
    return np.asarray(covariance * np.outer(share, share))


def _nuisances(estimate: MapEstimate, samples: Samples) -> MappingProxyType[str, Estimate]:
    """Return the estimates of the errors that readings share, by name."""
    sampled, nuisances = estimate.posterior.by_name(samples.x), dict[str, Estimate]()
    for name, value in estimate.values.items():
        hidden = (*FRICTIONS, COMMON_ERROR, STRAIGHTNESS)
        if name in hidden or name.startswith(ROUNDING):
            continue
        sigma = float(np.sqrt(np.cov(sampled[name], aweights=samples.weight, ddof=0)))
        nuisances[name] = Estimate(float(value[0]), sigma)
    return MappingProxyType(nuisances)


def _influences(
    fit: FrictionFit, refits: Mapping[str, MapEstimate | None]
) -> tuple[Influence, ...]:
    """Return the influence of each reading: chi2 and shift of the frictions without it."""
    sigma = np.maximum(np.sqrt(np.diag(fit.covariance)), 1e-12)
    influences = []
    for words, refit in refits.items():
        if words.startswith(READING):
            number, chi2, shift = int(words.removeprefix(READING)), None, None
            if refit:
                moved = ((refit.x[:COUNT] - fit.values) / sigma).tolist()
                chi2, shift = refit.chi2, dict(zip(FRICTIONS, moved, strict=True))
            influences.append(Influence(number, chi2, shift))
    return tuple(influences)


def _naive(session: Session) -> FrictionFit:
    """Return the paper's fit, without notes."""
    from scipy.special import stdtrit

    from .paper_fit import two_lines
    from .stations import Stations

    stations = Stations.from_session(session)
    values, covariance = two_lines(stations)
    if values.min() < 0.0:
        name = FRICTIONS[int(values.argmin())]
        raise BadInput(
            f"{session.where}: the naive fit gives {name} = {values.min():.3g} {UNITS[name]}; it "
            "must be at least 0; use method='joint' or look for a misread value"
        )
    counts = [int(stations.parts[part].sum()) for part in ("straight", "bent") * 2]
    widths = stdtrit(np.array(counts) - 2, 0.5 + LEVEL / 2)
    sigma = np.sqrt(np.diag(covariance))
    wider = np.outer(widths, widths) / 1.96**2 * covariance
    samples = np.random.default_rng(2005).multivariate_normal(values, wider, KEPT_SAMPLES)
    posterior = posterior_of(session)
    start = posterior.by_name(posterior.start(values)[None])
    residuals = stations.sizes(start)
    return FrictionFit(
        "naive",
        session.setup.robot,
        values,
        covariance,
        np.maximum(np.column_stack([values - widths * sigma, values + widths * sigma]), 0.0),
        np.maximum(samples, 0.0),
        chi2=float(residuals @ residuals),
        dof=len(stations) - COUNT,
        residuals=tuple(residuals.tolist()),
        session_name=session.setup.name,
        session_sha256=session.sha256,
    )
