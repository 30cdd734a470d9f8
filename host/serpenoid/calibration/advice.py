"""Which reading to take next: the one that shrinks the speeds' bands most, by the fit's own sums.

A reading that is yet to be taken is put beside the others at its expected value, at an incline that
the treadmill can be set to: its row of the Jacobian adds to the information, a bend set anew brings
its own offset with it, a set point read again its rounding error. Of speed, the
sampled frictions give the share that goes with friction linearly (a regression of sampled speeds,
not a tangent); the new covariance says what is left of it. That ranks the readings. What is told
of the band, now and after the best reading, is sampled as `compare` samples it, since bands are
skewed where wheels stick. A gait run tells of its own speed, but for the joints' amplitude, which
it shares with the gaits that matter; friction fits leave gait runs out, and so does this unless
asked.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..model.checks import check_kind
from ..model.drives import ServoKind
from ..model.errors import BadInput
from ..model.gait import Gait
from ..servos.catalogue import HOBBY
from .advising.next_reading import Advice, NextReading, gaits_that_matter
from .advising.on_floor import advise_on_floor
from .advising.speed_slopes import SpeedSlopes, speed_slopes
from .advising.stations import places
from .filmed_joints import servo_seen
from .fitting.unknowns import Floats
from .friction_fit import fit_friction
from .friction_result import FrictionFit
from .kinds.station import Reading
from .session import Session
from .session_posterior import information_at, linear_covariance
from .speed_samples import (
    Progress,
    band_parts,
    servo_fields,
    servo_note,
)
from .taking.expected import Series

LAMBDAS_DEG = (0.0, 7.5, 15.0, 20.0, 30.0)  # further, the end joints stand beyond 60 degrees
_MOST_TIMES, _WORTH_ANOTHER = 5, 0.1


def advise(
    session: Session,
    gaits: Sequence[Gait] = (),
    *,
    samples: int = 48,
    lambdas_deg: Sequence[float] = LAMBDAS_DEG,
    runs: bool = False,
    servo: ServoKind | None = HOBBY,
    progress: Progress | None = None,
) -> Advice:
    """Rank the readings that could be taken next by the speed band they leave.

    Of a session on a floor pushes and slides, by how much each saves a minute of work.

    No reading is named at a voided one's place, beyond the plan's belt speed, or steeper than
    MOST_INCLINE_RAD or the steepest one taken.

    Parameters
    ----------
    session, gaits
        The readings so far, and the gaits that matter: the planned ones unless given.
    samples
        Number of frictions drawn from the fit.
    lambdas_deg
        Bends to choose from, degrees.
    runs
        Whether to count gait runs, those taken and those to take.
    servo
        The kind that moves the joints, as for `compare`; the note says when to measure it.
    progress
        Called with the gaits done.

    Returns
    -------
    Advice
        The band now and the readings, best first.

    Raises
    ------
    BadInput
        No gait, or readings that leave a parameter open: the message names one that would close it.

    Examples
    --------
    >>> session = sn.load_session("calibration_data/nirakh-2005")
    >>> gait = sn.Gait(alpha_rad=1.22, beta_rad=1.31, omega_rad_s=5.0)
    >>> found = sn.advise(session, [gait], servo=None, samples=16, lambdas_deg=(0.0, 15.0))
    >>> found.readings[0].kind
    'station'
    """
    check_kind("session", session, Session)
    if session.on_floor:
        return advise_on_floor(session, gaits, samples=samples, servo=servo, progress=progress)
    wanted = gaits_that_matter(session, gaits)
    if not session.kept:
        raise BadInput(f"{session.where}: no station was held, and no push; take one first")
    fit = fit_friction(session)
    whole = np.array(list(fit.whole_snake.values()))
    servo = servo and servo_seen(session.setup.driving(servo), session.kept_films, fit)
    slopes = speed_slopes(fit, wanted, samples, progress)
    ran = [_sigmas_of_runs(session, gait) if runs else [] for gait in wanted]
    readings = [
        _station(session, whole, (slopes, ran), at)
        for at in places(session, whole, [math.radians(bend) for bend in lambdas_deg])
    ]
    covariance = _covariance(session, whole)
    readings += [_gait_run(session, covariance, slopes, ran, j) for j in range(len(wanted)) if runs]
    bands = slopes.band(covariance, ran), slopes.band(covariance)
    return _ranked(session, fit, wanted, readings, bands, servo)


def _ranked(
    session: Session,
    fit: FrictionFit,
    wanted: tuple[Gait, ...],
    readings: list[NextReading],
    bands: tuple[float, float],
    servo: ServoKind | None,
) -> Advice:
    """Return the readings, best first; bands: by slopes now, with and without the runs taken."""
    if not readings:
        raise BadInput(
            f"{session.where}: no station that this treadmill can be set to tells more; take gait "
            "runs, or raise belt_speed_max_m_s in the plan"
        )
    with_runs, linear = bands
    parts = band_parts(fit, wanted, servo)
    now = parts.with_friction(with_runs / linear)
    total = [
        replace(
            r,
            band=parts.with_friction(r.band / linear),
            band_after_times=parts.with_friction(r.band_after_times / linear),
        )
        for r in sorted(readings, key=lambda r: r.band)
    ]
    then = _after(session, fit, total[0])
    last = total[0].band_after_times
    after = last if then is None else band_parts(then, wanted, servo, before=fit).whole
    notes = filter(None, (_ratchet_note(session, fit), servo_note(parts, servo, after)))
    fields = servo_fields(servo, parts)
    return Advice(wanted, now, after, tuple(total), " ".join(notes), *fields, fit.alarms)


def _after(session: Session, fit: FrictionFit, told: NextReading) -> FrictionFit | None:
    """Return the fit as a station taken as told would leave it, at the same values."""
    if told.kind != "station":
        return None
    first = max(r.number for r in session.readings) + 1
    more = (
        Reading(
            first + k,
            told.lambda_rad or 0.0,
            told.incline_rad or 0.0,
            told.belt_speed_m_s or 0.0,
            facing=told.facing,
            bend=told.bend or "zigzag",
        )
        for k in range(told.times)
    )
    values = np.array(list(fit.whole_snake.values()))
    before = _covariance(session, values)
    after = _covariance(replace(session, readings=(*session.readings, *more)), values)
    return fit.as_after(before, after)


def _ratchet_note(session: Session, fit: FrictionFit) -> str:
    if not session.setup.procedure.ratchet or len(fit.names) > 4:
        return ""
    return (
        "The plan says that the wheels are ratchets, but nothing tells how they roll backwards: "
        "these bands take them to roll alike both ways. Hold two straight stations facing up first."
    )


def _covariance(session: Session, whole: Floats) -> Floats:
    """Return the parameters' covariance that a session's readings leave, near these values."""
    return linear_covariance(session, information_at(session, whole))


def _sigmas_of_runs(session: Session, gait: Gait) -> list[float]:
    """Return the standard deviations of this gait's runs (the board's clock is 1 % off at most)."""
    return [
        r.speed_sigma_m_s
        for r in session.kept_gait_runs
        if abs(r.omega_rad_s / gait.omega_rad_s - 1.0) < 0.01
        and math.isclose(r.alpha_rad, gait.alpha_rad, abs_tol=1e-3)
        and math.isclose(r.beta_rad, gait.beta_rad, abs_tol=1e-3)
    ]


def _station(
    session: Session,
    whole: Floats,
    speeds: tuple[SpeedSlopes, list[list[float]]],
    at: tuple[Series, float, float],
) -> NextReading:
    (slopes, ran), (series, incline, slip) = speeds, at
    first = max(r.number for r in session.readings) + 1
    bands = []
    for times in range(1, _MOST_TIMES + 1):
        more = (
            Reading(
                first + k, series.lambda_rad, incline, slip, facing=series.facing, bend=series.bend
            )
            for k in range(times)
        )
        after = replace(session, readings=(*session.readings, *more))
        bands.append(slopes.band(_covariance(after, whole), ran))
        if times > 1 and bands[-1] > (1.0 - _WORTH_ANOTHER) * bands[-2]:
            break
    times = _worth(bands)
    return NextReading(
        "station",
        bands[0],
        times,
        bands[times - 1],
        lambda_rad=series.lambda_rad,
        incline_rad=incline,
        belt_speed_m_s=slip,
        facing=series.facing,
        bend=series.bend if series.lambda_rad else "",
    )


def _worth(bands: list[float]) -> int:
    """Return how often to take a reading: until once more shrinks the band by less than a tenth."""
    times = 1
    while times < len(bands) and bands[times] < (1.0 - _WORTH_ANOTHER) * bands[times - 1]:
        times += 1
    return times


def _gait_run(
    session: Session, covariance: Floats, slopes: SpeedSlopes, ran: list[list[float]], j: int
) -> NextReading:
    """Return what a run of gait j brings: it measures its own speed, with a stopwatch."""
    gait, v = slopes.gaits[j], float(slopes.speed_m_s[j])
    sigma = session.setup.stopwatch.speed(1.0, 1.0 / v)[1]
    bands = []
    for times in range(1, _MOST_TIMES + 1):
        more = [[*s, *([sigma] * times if k == j else [])] for k, s in enumerate(ran)]
        bands.append(slopes.band(covariance, more))
    times = _worth(bands)
    return NextReading(
        "gait",
        bands[0],
        times,
        bands[times - 1],
        alpha_rad=gait.alpha_rad,
        beta_rad=gait.beta_rad,
        frequency_hz=gait.omega_rad_s / (2 * math.pi),
    )
