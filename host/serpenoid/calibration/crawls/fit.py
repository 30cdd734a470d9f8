"""From a session's crawls to a friction fit: beside its other readings, or alone."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from types import MappingProxyType

import numpy as np

from ...base.errors import BadInput, Diverged, NotConverged
from ...base.particles import tempered
from ...model.drives import ServoKind
from ...model.ground import Ground
from ...session.session import Session
from ..fit_of_draws import DRAWS, fit_of_draws
from ..fitting.posterior import Draws, Posterior
from ..fitting.stations import Stations
from ..fitting.unknowns import Floats
from ..friction_result import (
    AMPLITUDE,
    DOUBTFUL,
    Estimate,
    FitDraws,
    FittedServos,
    FrictionFit,
    ground_of,
    weak_notes,
)
from ..session_posterior import mode_of, posterior_of, scale_sigmas, usual_frictions
from ..speeds import SpeedTable
from .data import CrawlData, servos_of
from .level import Slope, floor_slope, is_sloped, on_level
from .posterior import MOVES, NEVER, Beforehand, CrawlDraws, CrawlPosterior
from .servos import SERVO_DRAWS, with_near_ones

# Where nothing else is known, frictions are the usual ones within a factor of e or so, and no two
# of them alike.
USUAL_SIGMA = 1.0
LEAST_GAITS = 4  # alone
_ROUGH = 4  # of the draws, one in so many where crawls are not yet on level ground
_OPEN = 2.0  # upper end over lower: such a friction is not told


def with_crawls(
    session: Session,
    other: FrictionFit | None,
    servo: ServoKind | None = None,
    seed: int = 2005,
) -> FrictionFit:
    """Fit friction to a session's crawls and all its other readings.

    The fit's values are the likeliest; intervals and covariance are those of draws, which it keeps.
    other: the fit of its stations and pushes; None where there are none, or these leave
    frictions open. Raises BadInput where crawls are too few.
    """
    data = CrawlData.of(session)
    _check(session, data, other)
    others, x = _others(session, other is None, seed)
    shared = others.nuisances(others.by_name(x)).items()
    slope = floor_slope(session, {n: Estimate(float(d.mean()), float(d.std())) for n, d in shared})
    robot, whole = session.setup.robot, np.median(x[:, : others.frictions], axis=0)
    sloped, effects, speeds, drawn = is_sloped(session), None, None, None
    # crawls on level ground, and servos, depend on where the frictions are
    for last in (False, True) if sloped or other is None else (True,):
        ground = ground_of(robot.links, whole.tolist())
        if sloped:
            data = CrawlData.of(_on_level(session, ground, slope, drawn))
        model = data.model(robot, ground)
        if effects is None or other is None:
            effects = model.effects(servos_of(servo, SERVO_DRAWS, seed))
        speeds = speeds or SpeedTable(partial(model.ideal, unfound_m_s=np.nan))
        posterior = CrawlPosterior(others, data, speeds, effects, wide=other is None)
        if last and servo is not None and not servo.exact and not servo.drawn:
            posterior = with_near_ones(posterior, x[::_ROUGH], servo, model.effects, seed)
        drawn = posterior.draw(x if last else x[::_ROUGH], seed)
        whole = drawn.best_whole
    assert drawn is not None  # the loop runs once at least
    fit = _result(session, other, drawn)
    if servo is None or servo.exact:
        return fit
    pool, index = drawn.posterior.effects.servos, tuple(drawn.servo.tolist())
    return replace(fit, servos=FittedServos(servo.name, pool, index, drawn.best_servo))


def _check(session: Session, data: CrawlData, other: FrictionFit | None) -> None:
    alone = other is None and not session.on_floor
    if len(data) < (LEAST_GAITS if alone else 1):
        least = f" (alone, {LEAST_GAITS} gaits at least)" if alone else ""
        raise BadInput(
            f"{session.where}: {len(data)} crawl(s) cannot be fitted{least}; take crawls of other "
            "gaits, or pushes, which tell each friction"
        )


def _others(session: Session, is_open: bool, seed: int) -> tuple[Posterior, Floats]:
    """Return the posterior of all other readings, and draws of its unknowns (DRAWS, D).

    is_open: they leave frictions open, which are then the usual ones beforehand.
    """
    if not is_open:
        mode = mode_of(session)
        return _with_belt(session, mode.posterior.draws(mode, seed).alike(DRAWS))
    usual = usual_frictions(session)
    known = Beforehand(np.log(usual), USUAL_SIGMA * np.eye(len(usual)))
    posterior = Posterior((known, *posterior_of(session).blocks))
    posterior = posterior.mode(posterior.start(usual)).posterior
    size, of = len(posterior.unknowns), len(usual)

    def unknowns(u: Floats) -> Floats:
        return np.column_stack([known.whole(u[:, :of]), u[:, of:]])

    def before(u: Floats) -> Floats:
        inside = (unknowns(u) >= posterior.low).all(axis=1)
        return np.where(inside, -0.5 * np.sum(u**2, axis=1), NEVER)

    def ratio(u: Floats) -> Floats:
        log = before(u)
        return np.where(log > NEVER, posterior.log_density(unknowns(u)) - log, 0.0)

    rng = np.random.default_rng(seed)
    u = rng.normal(size=(4 * DRAWS, size))
    u = u[before(u) > NEVER][:DRAWS]
    return posterior, unknowns(tempered(u, before, ratio, rng, 2 * MOVES)[0])


def _with_belt(session: Session, draws: Draws) -> tuple[Posterior, Floats]:
    """Return posterior and draws with the belt's scale among the unknowns: crawls may tell it.

    Without crawls nothing does: a belt k times as fast makes viscous frictions k times as small.
    """
    posterior, sigma = draws.posterior, scale_sigmas(session, draws.posterior)[0]
    if sigma == 0.0:
        return posterior, draws.x
    blocks = [
        replace(block, belt_sigma=sigma) if isinstance(block, Stations) else block
        for block in posterior.blocks
    ]
    belt = np.random.default_rng(DRAWS).normal(size=len(draws.x))
    values = {
        name: value / (1.0 + sigma * belt) if name in ("ct", "cn") else value
        for name, value in draws.values.items()
    } | {"belt": belt}
    posterior = replace(posterior, blocks=tuple(blocks))
    return posterior, np.stack([values[name] for name in posterior.names], axis=1)


def _on_level(session: Session, ground: Ground, slope: Slope, drawn: CrawlDraws | None) -> Session:
    """Return the session on level ground, as the likeliest servo drawn so far moves the joints."""
    robot = session.setup.robot
    if drawn is not None and drawn.posterior.effects.servos:
        servo = drawn.posterior.effects.servos[drawn.best_servo]
        try:
            return on_level(session, robot, ground, slope, servo, drawn.best_amplitude)
        except (Diverged, NotConverged):
            pass  # as the films showed the joints
    return on_level(session, robot, ground, slope)


def _result(session: Session, other: FrictionFit | None, drawn: CrawlDraws) -> FrictionFit:
    """Return the fit with notes; other's alarms stay."""
    posterior, data = drawn.posterior, drawn.posterior.data
    x = posterior.unknowns(np.vstack([drawn.best, drawn.z]))
    amplitude, even = posterior.amplitude(drawn.z), np.full(len(drawn.z), 1.0 / len(drawn.z))
    mode = posterior.others.at(x[0])
    fit = fit_of_draws(session, mode, Draws(posterior.others, x[1:], even, even))
    fit = replace(
        fit,
        method="crawls" if other is None else "joint, with crawls",
        chi2=drawn.chi2,
        dof=fit.dof + len(data) + len(data.gain),
        nuisances=MappingProxyType(
            dict(fit.nuisances)
            | {"joint_amplitude": Estimate(drawn.best_amplitude, float(amplitude.std()))}
        ),
        session_sha256=session.sha256_with_crawls,
        draws=FitDraws((*fit.draws.names, AMPLITUDE), np.column_stack([fit.draws.rows, amplitude])),
    )
    contradiction, earlier = _contradicts(fit), other or replace(fit, notes=(), alarms=())
    kept = [note for note in earlier.notes if note not in weak_notes(earlier)]
    return replace(
        fit,
        alarms=(*contradiction, *earlier.alarms),
        notes=(*contradiction, *_notes(fit, data), *kept),
    )


def _contradicts(fit: FrictionFit) -> list[str]:
    if fit.p_value is None or fit.p_value > DOUBTFUL:
        return []
    return [
        f"{fit.chi2_in_words}: the crawls do not agree with each other, or with the other "
        "readings, by more than their errors allow, so do not trust the intervals. `serpenoid "
        "compare` shows each crawl beside what the other readings predict."
    ]


def _notes(fit: FrictionFit, data: CrawlData) -> list[str]:
    mean, sigma = fit.nuisances["joint_amplitude"]
    notes = [
        f"Crawls of {len(data)} gait(s) are fitted, too: `compare` with this fit is no test of "
        f"them. Joints' amplitude {mean:.1%} ± {sigma:.1%} of the commanded one."
    ]
    open_ones = [n for n, (low, high) in fit.intervals.items() if high > _OPEN * low]
    if open_ones:
        named = ", ".join(open_ones)
        notes.insert(
            0,
            (
                f"Speeds only: the crawls do not tell {named} apart from the rest. Speeds of gaits "
                "like those that were run are known better than any friction; pushes tell each one."
            ),
        )
    return notes
