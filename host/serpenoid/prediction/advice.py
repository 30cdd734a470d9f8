"""Which reading to take next: the one that saves most of the speeds' band a minute.

A reading that is yet to be taken is put beside the others at its expected value, and the
posterior's slopes say what friction's covariance is then. A gait run tells of its own speed, but
for the joints' amplitude, which it shares with the gaits that matter; friction fits leave gait runs
out, and so does this unless asked.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace

from ..base.checks import check_kind
from ..base.errors import BadInput
from ..calibration.crawls.data import same_command
from ..calibration.fitting.posterior import Mode
from ..calibration.friction_fit import fit_friction
from ..calibration.session_posterior import covariance_after, mode_of
from ..calibration.speeds import Progress
from ..model.drives import ServoKind
from ..model.gait import Gait, gait_name
from ..servos.catalogue import HOBBY
from ..servos.speed_limit import too_fast_text
from ..session.gait_run import GaitRun
from ..session.session import Session
from .filmed_joints import servo_seen
from .floor_readings import floor_options
from .next_reading import (
    Advice,
    NextReading,
    Option,
    gaits_that_matter,
    next_number,
    repeated,
)
from .speed_bands import SpeedBands, speed_bands
from .stations import station_options

LAMBDAS_DEG = (0.0, 7.5, 15.0, 20.0, 30.0)  # further, the end joints stand beyond 60 degrees
_WORTH_ANOTHER = 0.1
_ON_FLOOR = (
    "By minutes of work: the first saves most of the band a minute. Once pushes are filmed, what "
    "joints really do is the larger part: a film of a crawl tells it (`serpenoid video`)."
)


def advise(
    session: Session,
    gaits: Sequence[Gait] = (),
    *,
    samples: int = 64,
    lambdas_deg: Sequence[float] = LAMBDAS_DEG,
    runs: bool = False,
    servo: ServoKind | None = HOBBY,
    progress: Progress | None = None,
) -> Advice:
    """Rank the readings that could be taken next by the speed band they leave.

    Of a session on a floor pushes. No reading is named at a voided one's place, beyond
    the plan's belt speed, or steeper than MOST_INCLINE_RAD or the steepest one taken.

    Parameters
    ----------
    session, gaits
        The readings so far, and the gaits that matter: the planned ones unless given. Those that
        are too fast for the servo have no band and do not count; the note names them.
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
        No gait that the servo can follow, or readings that leave a parameter open: the message
        names one that would close it.

    Examples
    --------
    >>> session = sn.load_session("calibration_data/nirakh-2005")
    >>> gait = sn.Gait(alpha_rad=1.22, beta_rad=1.31, omega_rad_s=4.0)
    >>> advice = sn.advise(session, [gait], servo=None, samples=16, lambdas_deg=(0.0, 15.0))
    >>> advice.readings[0].kind
    'station'
    """
    check_kind("session", session, Session)
    wanted = gaits_that_matter(session, gaits)
    if not session.kept and not session.on_floor:
        raise BadInput(f"{session.where}: no station was held, and no push; take one first")
    fit, mode = fit_friction(session), mode_of(session)
    servo = servo and servo_seen(session.setup.driving(servo), session.kept_films, fit)
    wanted, too_fast = _that_servos_follow(session, wanted, servo)
    speeds = speed_bands(fit, wanted, servo, samples, progress)
    linear = speeds.by_friction(covariance_after(session, mode))

    def band(grown: Session) -> float:
        ran = [_sigmas_of_runs(grown, gait) for gait in wanted] if runs else ()
        return speeds.after(speeds.by_friction(covariance_after(grown, mode), ran) / linear)

    bends = [math.radians(bend) for bend in lambdas_deg]
    readings = [_after(*option, band) for option in _options(session, mode, speeds, bends, runs)]
    now = band(session)
    readings.sort(key=lambda r: (r.band - now) / (r.minutes or 1.0))
    after = readings[0].band_after_times
    told = _ON_FLOOR if session.on_floor else ""
    notes = (servo and servo.remark, *too_fast, told, speeds.servo_note(servo, after))
    note = " ".join(filter(None, notes))
    measured = None if servo is None or servo.drawn else speeds.servo_measured
    named = servo and servo.name
    return Advice(wanted, now, after, tuple(readings), note, named, measured, fit.alarms)


def _that_servos_follow(
    session: Session, gaits: Sequence[Gait], servo: ServoKind | None
) -> tuple[tuple[Gait, ...], list[str]]:
    """Return the gaits whose speed has a band, and the sentences about those that are too fast.

    Raises BadInput where all are.
    """
    texts = [too_fast_text(gait, servo, gait_name(gait)) for gait in gaits]
    slow = tuple(gait for gait, text in zip(gaits, texts, strict=True) if not text)
    if not slow:
        raise BadInput(
            f"{session.where}: {' '.join(texts)} So no speed has a band to make narrower; name "
            "a slower gait"
        )
    return slow, [text for text in texts if text]


def _options(
    session: Session, mode: Mode, speeds: SpeedBands, bends: Sequence[float], runs: bool
) -> list[Option]:
    """Return what could be taken next; raises BadInput where that is nothing."""
    if session.on_floor:
        return list(floor_options(session, mode))
    options = list(station_options(session, mode, bends))
    if runs:
        pairs = zip(speeds.gaits, speeds.speed_m_s.tolist(), strict=True)
        options += [_gait_run(session, gait, speed_m_s) for gait, speed_m_s in pairs]
    if not options:
        raise BadInput(
            f"{session.where}: no station that this treadmill can be set to tells more; take gait "
            "runs, or raise belt_speed_max_m_s in the plan"
        )
    return options


def _after(
    shown: NextReading, grown: Iterable[Session], band: Callable[[Session], float]
) -> NextReading:
    """Return a reading with the bands after it, as often as once more saves a tenth."""
    bands: list[float] = []
    for left in map(band, grown):
        if bands and left > (1.0 - _WORTH_ANOTHER) * bands[-1]:
            break
        bands.append(left)
    times = shown.times * len(bands)
    return replace(shown, band=bands[0], times=times, band_after_times=bands[-1])


def _sigmas_of_runs(session: Session, gait: Gait) -> list[float]:
    """Return the standard deviations of this gait's runs."""
    return [r.speed_sigma_m_s for r in session.kept_gait_runs if same_command(r.gait, gait)]


def _gait_run(session: Session, gait: Gait, speed_m_s: float) -> Option:
    """Return a run of a gait: it measures its own speed, with a stopwatch."""
    sigma = session.setup.stopwatch.speed(1.0, 1.0 / speed_m_s)[1]
    alpha, beta, omega = gait.alpha_rad, gait.beta_rad, gait.omega_rad_s
    run = GaitRun(next_number(session), alpha, beta, omega, speed_m_s, sigma)
    rate = omega / (2 * math.pi)
    shown = NextReading("gait", alpha_rad=alpha, beta_rad=beta, frequency_hz=rate)
    return shown, repeated(session, "gait_runs", run)
