"""From a session's crawls to a friction fit: beside the other readings' fit, or alone."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from types import MappingProxyType

import numpy as np

from ...model.drives import ServoKind
from ...model.errors import BadInput, Diverged, NotConverged
from ...model.ground import Ground
from ...model.robot import Robot
from ..fitting.shared import FRICTIONS, shared_covariance
from ..friction_result import (
    AMPLITUDE,
    DOUBTFUL,
    LEVEL,
    Estimate,
    FitDraws,
    FittedServos,
    FrictionFit,
    ground_of,
    weak_notes,
    with_values,
)
from ..session import Session
from ..session_posterior import posterior_of, usual_frictions
from ..speeds import AMPLITUDE_SIGMA, Array, ServoEffects, Speeds
from .data import CrawlData, servos_of
from .level import floor_slope, is_sloped, on_level
from .posterior import POINTS, ROUGH_POINTS, Before, Drawn, Posterior
from .servos import SERVO_DRAWS, with_near_ones

# Where nothing else is known, frictions are the usual ones within a factor of e or so, and no two
# of them alike.
USUAL_SIGMA = 1.0
LEAST_GAITS = 4  # alone
_FOLLOWING = 6  # steps of what follows given frictions
_FEW = 60.0  # independent draws: fewer make no interval
_MISREAD = "Crawl(s) {} held for misread: they count next to nothing. Look them up."
_OPEN = 2.0  # upper end over lower: such a friction is not told


def fit_crawls(
    session: Session,
    other: FrictionFit | None,
    servo: ServoKind | None,
    seed: int = 2005,
    speeds: Speeds | None = None,
    effects: ServoEffects | None = None,
    misread: bool = False,
) -> FrictionFit:
    """Fit friction to crawls, with another fit of the session's pushes and stations or without.

    The fit's values are the likeliest; intervals and covariance are those of draws, which it keeps.
    other: None where there is nothing else, or pushes and slides that leave frictions open: these
    then count by their chi2. speeds, effects: predict the crawls, and what servos do to them;
    solved for unless given. misread: any crawl may be a misreading. Raises BadInput where crawls
    are too few, NotConverged where draws are.
    """
    data, open_pushes = CrawlData.of(session), other is None and session.on_floor
    _check(session, data, other)
    robot, before = session.setup.robot, _before(session, other)
    slope, sloped = floor_slope(session, other), is_sloped(session)
    at, pool, drawn = np.exp(before.mean), effects, None
    leads = servo is not None and sloped  # what a slope does depends on the servo, too
    again = leads or (other is None and (servo is not None or open_pushes))
    for last in (False, True) if again else (True,):  # all this depends on where the frictions are
        if open_pushes:
            before, slope = _with_pushes(session, before, at)
        ground = ground_of(robot.links, at.tolist())
        if sloped:
            level = _on_level(session, robot, ground, slope, drawn if leads else None)
            data = CrawlData.of(level)
        model = data.model(robot, ground)
        posterior = partial(
            Posterior, data, before, speeds or partial(model.ideal, unfound_m_s=0.0)
        )
        if effects is None and (pool is None or not before.narrow):
            pool = model.effects(servos_of(servo, SERVO_DRAWS, seed))
        assert pool is not None
        if last and before.narrow and servo is not None and not servo.exact and not servo.drawn:
            pool = with_near_ones(pool, servo, posterior, model.effects, seed)
        drawn = posterior(pool, misread).draw(seed, POINTS if last else ROUGH_POINTS)
        at = drawn.best_whole
    assert drawn is not None  # the loop runs once at least
    if drawn.effective < _FEW:
        raise NotConverged(
            f"{session.where}: the crawls' posterior was not found: {drawn.effective:.0f} "
            "independent draws; look for a crawl that was misread, or fit without crawls"
        )
    fit = _result(session, other, data, drawn, seed)
    if open_pushes:
        told = dict(fit.nuisances) | {"floor_slope_rad": slope}
        fit = replace(fit, nuisances=MappingProxyType(told))
    if servo is None or servo.exact:
        return fit
    index = tuple(drawn.alike(POINTS, seed)[2].tolist())
    used = drawn.posterior.effects.servos
    return replace(fit, servos=FittedServos(servo.name, used, index, drawn.best_servo))


def _on_level(
    session: Session, robot: Robot, ground: Ground, slope: Estimate, drawn: Drawn | None
) -> Session:
    """Return the session on level ground, as the likeliest servo drawn so far moves the joints."""
    if drawn is not None and drawn.posterior.effects.servos:
        servo = drawn.posterior.effects.servos[drawn.best_servo]
        try:
            return on_level(session, robot, ground, slope, servo, drawn.best_amplitude)
        except (Diverged, NotConverged):
            pass  # as the films showed the joints
    return on_level(session, robot, ground, slope)


def _check(session: Session, data: CrawlData, other: FrictionFit | None) -> None:
    alone = other is None and not session.on_floor
    if len(data) < (LEAST_GAITS if alone else 1):
        least = f" (alone, {LEAST_GAITS} gaits at least)" if alone else ""
        raise BadInput(
            f"{session.where}: {len(data)} crawl(s) cannot be fitted{least}; take crawls of other "
            "gaits, or pushes, which tell each friction"
        )


def _before(session: Session, other: FrictionFit | None) -> Before:
    """Return what is known of friction for the mass as stated, its own error left out."""
    if other is None:
        back = any(push.facing == "back" for push in session.kept_pushes)
        usual = usual_frictions(session, 6 if back else 4)
        return Before(np.log(usual), USUAL_SIGMA * np.eye(len(usual)), AMPLITUDE_SIGMA)
    values = np.array(list(other.whole_snake.values()))
    sigma = np.sqrt(np.diag(other.covariance))
    centre = np.maximum(values, 0.3 * sigma)  # one at its limit of 0 is somewhere below its sigma
    alone = other.covariance - shared_covariance(values, 0.0, session.mass_sigma)
    own = np.sqrt(np.diag(alone))
    wide = np.sqrt(np.log1p((own / centre) ** 2)) / own  # of a logarithm, with the same variance
    root = np.linalg.cholesky(alone * np.outer(wide, wide) + 1e-12 * np.eye(len(own)))
    return Before(np.log(centre), np.asarray(root, dtype=np.float64), AMPLITUDE_SIGMA)


def _with_pushes(session: Session, before: Before, at: Array) -> tuple[Before, Estimate]:
    """Return what was known before with pushes and slides that leave frictions open; the slope.

    Their chi2 near the frictions `at`, all else let follow, is |R f + r|^2 over frictions f.
    """
    posterior = posterior_of(session)
    of, x = posterior.frictions, posterior.start(at)
    posterior = posterior.near(x)
    for _ in range(_FOLLOWING):
        mode = posterior.near(x).at(x)
        x[of:] -= np.linalg.lstsq(mode.slopes[:, of:], mode.residuals, rcond=None)[0]
        x = np.maximum(x, posterior.low)
    mode = posterior.near(x).at(x)
    theirs, rows = mode.slopes[:, of:], mode.slopes[:, :of]
    both = np.column_stack([rows, mode.residuals - rows @ at])
    both -= theirs @ np.linalg.lstsq(theirs, both, rcond=None)[0]
    upper = np.asarray(np.linalg.qr(both, mode="r"), dtype=np.float64)
    slopes = [k for k, name in enumerate(posterior.names) if name.startswith("along")]
    slope, unit = Estimate(0.0, 1.0), session.setup.floor.slope_sigma_rad
    if slopes:
        free = np.linalg.pinv(theirs.T @ theirs)[slopes[0] - of, slopes[0] - of]
        slope = Estimate(float(x[slopes[0]]), float(free) ** 0.5)
    return replace(before, rows=upper[:, :of], values=upper[:, of]), Estimate(
        unit * slope.value, unit * slope.sigma
    )


def _result(
    session: Session,
    other: FrictionFit | None,
    data: CrawlData,
    drawn: Drawn,
    seed: int,
) -> FrictionFit:
    whole, amplitude, _ = drawn.alike(POINTS, seed)
    mass = 1.0 + session.mass_sigma * np.random.default_rng(seed).normal(size=len(whole))
    whole = whole * mass[:, None]
    tail = (1.0 - LEVEL) / 2
    ends = np.quantile(whole, [tail, 1.0 - tail], axis=0)
    values = drawn.best_whole
    ends = np.stack([np.minimum(ends[0], values), np.maximum(ends[1], values)], axis=1)
    bare = with_values(session, values, np.cov(whole.T), ends)
    common = other or bare
    doubted = zip(drawn.misread.tolist(), data.numbers, strict=False)
    outliers = [number for bad, numbers in doubted if bad for number in numbers]
    fit = replace(
        common,
        method="crawls" if other is None else f"{other.method}, with crawls",
        parameters=bare.parameters,
        intervals=bare.intervals,
        covariance=bare.covariance,
        ground=bare.ground,
        chi2=common.chi2 + drawn.chi2,
        dof=common.dof + int(np.sum(~drawn.misread)) + _open_readings(session, other),
        outliers=(*common.outliers, *outliers),
        nuisances=MappingProxyType(
            dict(common.nuisances)
            | {"joint_amplitude": Estimate(drawn.best_amplitude, float(amplitude.std()))}
        ),
        session_sha256=session.sha256_with_crawls,
        draws=FitDraws((*FRICTIONS[: len(values)], AMPLITUDE), np.column_stack([whole, amplitude])),
    )
    alarms = (*_contradicts(fit), *common.alarms)
    kept = [note for note in common.notes if note not in weak_notes(common)]
    misread = [_MISREAD.format(", ".join(map(str, outliers)))] if outliers else []
    notes = (*_contradicts(fit), *_notes(fit, data), *misread, *kept)
    return replace(fit, alarms=alarms, notes=notes)


def _contradicts(fit: FrictionFit) -> list[str]:
    if fit.p_value is None or fit.p_value > DOUBTFUL:
        return []
    return [
        f"{fit.chi2_in_words}: the crawls do not agree with each other, or with the other "
        "readings, by more than their errors allow, so do not trust the intervals. `serpenoid "
        "compare` shows each crawl beside what the other readings predict."
    ]


def _open_readings(session: Session, other: FrictionFit | None) -> int:
    """Return how many readings of open pushes and slides count, less what is each push's alone."""
    if other is not None or not session.on_floor:
        return 0
    posterior = posterior_of(session)
    return int(np.sum(posterior.numbers >= 0)) - posterior.eliminated


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
