"""Which reading to take next: the one that shrinks the band of the gaits in question most a minute.

A reading that is yet to be taken is put beside the others at its expected value, and the
posterior's slopes say what friction's covariance is then.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from ..base.checks import check_kind
from ..base.errors import BadInput
from ..base.rows import Result
from ..base.vectors import Array
from ..friction.fit import covariance_after, fit_friction, map_estimate
from ..model.drives import ServoKind
from ..model.gait import Gait, gait_name
from ..servos.catalogue import HOBBY
from ..servos.speed_limit import too_fast_text
from ..session.crawls import as_run, crawls_by_command, driving, same_command
from ..session.session import Session
from .band import predict
from .next_readings import NextReading, candidates
from .speeds import SAMPLES, Progress, Samples, draw_samples

WORTH = 0.1  # share of the band: a reading that saves less is not worth its time
SERVO_LEFT = 0.5  # part of the servos' share of the band that a bench test of one joint leaves
SERVO_TEST_MIN, FILM_MIN = 30.0, 10.0
SHOWN = 5  # readings of a table


@dataclass(frozen=True)
class Advice(Result):
    """Hold the present speed band and the readings that would shrink it.

    Attributes
    ----------
    gaits
        The gaits whose speeds count.
    band
        Half of the 95 % band of speed, relative, mean over the gaits; `compare` shows the same.
    readings
        Readings that can be taken next; first the one that saves most of the band a minute.
    note
        A remark for the user, or "".
    servo
        Name of the kind of servo; None for joints that follow the gait.
    fit_alarms
        Why the friction fit that this rests on is not to be trusted.

    Examples
    --------
    >>> session = sn.load_session("calibration_data/nirakh-2005")
    >>> gait = sn.Gait(alpha_rad=1.22, beta_rad=1.31, omega_rad_s=4.0)
    >>> advice = sn.advise(session, [gait], servo=None, samples=16)
    >>> bool(advice.best.band < advice.band)
    True
    """

    gaits: tuple[Gait, ...]
    band: float
    readings: tuple[NextReading, ...]
    note: str = ""
    servo: str | None = None
    fit_alarms: tuple[str, ...] = ()

    @property
    def best(self) -> NextReading:
        """Return the reading that saves most of the band a minute."""
        return self.readings[0]

    @property
    def worth(self) -> bool:
        """Return whether any reading saves a tenth of the band."""
        return any(reading.band <= (1.0 - WORTH) * self.band for reading in self.readings)

    def in_words(self) -> str:
        """Return which reading to take, or that none is worth its time."""
        best, present = self.best, f"±{100 * self.band:.2g} %"
        text = (
            f"Take next: {best.words} ({best.minutes:.0f} minutes); the speed is then known to "
            f"±{100 * best.band:.2g} %, now {present}."
            if self.worth
            else f"No further reading is worth its time: none makes the speed's band, {present}, a "
            "tenth narrower."
        )
        return f"{text} {self.note}".strip()

    def table(self, verbose: bool = True) -> tuple[list[str], list[list[str]]]:
        """Return the best readings and the speed's band after each; none where words do."""
        if not self.worth:
            return [], []
        cells = [
            [reading.words, f"{reading.minutes:.0f}", f"±{reading.band:.1%}"]
            for reading in self.readings[:SHOWN]
        ]
        return ["reading", "minutes", "speed then known to"], cells

    def to_dict(self) -> dict[str, Any]:
        """Return the figures by name; fit_alarms only where there are any."""
        values = asdict(self)
        alarms: tuple[str, ...] = values.pop("fit_alarms")
        values["worth"] = self.worth
        return values | ({"fit_alarms": list(alarms)} if alarms else {})


def advise(
    session: Session,
    gaits: Sequence[Gait] = (),
    *,
    samples: int = SAMPLES,
    servo: ServoKind | None = HOBBY,
    progress: Progress | None = None,
) -> Advice:
    """Rank the readings that could be taken next by what they save of the speed band a minute.

    On a treadmill stations, on a floor pushes; a film where the session has films or tags; a bench
    test where the servo was not measured. No station is named at a voided one's place, beyond the
    plan's belt speed, or steeper than home treadmills or the steepest one taken.

    Parameters
    ----------
    session
        The readings so far.
    gaits
        The gaits that matter: the planned ones unless given; the note names those too fast.
    samples
        Number of frictions drawn from the fit.
    servo
        The kind that moves the joints, as for `compare`.
    progress
        Called with the share of the gaits done, 0 to 1.

    Returns
    -------
    Advice
        The band now and the readings, best first.

    Raises
    ------
    BadInput
        No gait that the servo can follow, or a parameter left open, with what would close it.

    Examples
    --------
    >>> session = sn.load_session("calibration_data/nirakh-2005")
    >>> sn.advise(session, [sn.Gait.degrees(70, 75, hertz=0.6)], servo=None).readings[0].kind
    'station'
    """
    check_kind("session", session, Session)
    asked_gaits = tuple(gaits) or as_run(session, session.setup.plan.gaits)
    if not asked_gaits:
        raise BadInput(f"{session.where}: no gait to predict; name one with --gait")
    if not session.kept_stations and not session.on_floor:
        raise BadInput(f"{session.where}: no station was held, and no push; take one first")
    fit, estimate = fit_friction(session), map_estimate(session)
    servo = servo and driving(session.setup, servo)
    too_fast = [too_fast_text(gait, servo, gait_name(gait)) for gait in asked_gaits]
    slow = tuple(gait for gait, text in zip(asked_gaits, too_fast, strict=True) if not text)
    if not slow:
        raise BadInput(
            f"{session.where}: {' '.join(too_fast)} So no speed has a band to make narrower; name "
            "a slower gait"
        )
    drawn, parts = draw_samples(fit, servo, count=samples), list[tuple[Array, Array]]()
    for gait in slow:
        parts.append(_slopes_and_halves(session, drawn, gait))
        if progress is not None:
            progress(len(parts) / len(slow))
    slopes = np.array([part[0] for part in parts])
    friction, joints, complete, filmed = np.array([part[1] for part in parts]).T
    present_band = float(np.mean(complete))
    other_variance = np.maximum(complete**2 - friction**2, 0.0)

    def variance(*more: Any) -> Array:
        """Return the variance of each gait's speed by friction, with more readings."""
        number = 1 + max(reading.number for reading in session.readings)
        expected = (replace(reading, number=number) for reading in more)
        grown = replace(session, readings=(*session.readings, *expected))
        return np.einsum("gi,ij,gj->g", slopes, covariance_after(grown, estimate), slopes)

    present_variance, readings = variance(), list[NextReading]()
    for candidate, more in candidates(session, estimate):
        shrunk = friction**2 * variance(*more) / present_variance
        band = float(np.mean(np.sqrt(other_variance + shrunk)))
        readings.append(replace(candidate, band=band))
    if servo is not None and not servo.drawn and not servo.exact:
        words = "a bench test of one joint (`serpenoid servo --test`)"
        joints = np.minimum(joints, complete)
        tested = np.sqrt(joints**2 + SERVO_LEFT**2 * (complete**2 - joints**2))
        readings.append(NextReading("servo", words, SERVO_TEST_MIN, float(np.mean(tested))))
    by_film = any(push.source == "film" for push in session.kept_pushes)
    if by_film or session.kept_films or session.setup.robot_table.tag_side_m:
        words, minutes = "a film of the crawling robot (`serpenoid video`)", FILM_MIN * len(slow)
        readings.append(NextReading("film", words, minutes, float(np.mean(filmed))))
    if not readings:
        raise BadInput(
            f"{session.where}: no station that this treadmill can be set to tells more; raise "
            "belt_speed_max_m_s in the plan"
        )
    # a reading that saves less than a tenth comes after those that are worth their time
    readings.sort(
        key=lambda r: (r.band > (1.0 - WORTH) * present_band, (r.band - present_band) / r.minutes)
    )
    note = " ".join(filter(None, [servo.remark if servo else "", *too_fast]))
    return Advice(slow, present_band, tuple(readings), note, servo and servo.name, fit.alarms)


def _slopes_and_halves(session: Session, samples: Samples, gait: Gait) -> tuple[Array, Array]:
    """Return the slopes (4,) of a speed by the frictions, and halves (4,) of its 95 % bands.

    The slopes are a regression of sampled speeds. The halves, over the speed, are of friction, with
    the joints' amplitude, with the servos, and the last one with joints as a film shows them.
    Raises BadInput for a gait that stands still.
    """
    centred = samples.frictions - samples.frictions.mean(axis=0)
    # a little of the fit's own covariance keeps frictions known all but exactly in their place
    ridge = 1e-6 * len(centred) * np.diag(np.diag(samples.fit.covariance))
    crawls = [crawl for crawl in crawls_by_command(session) if crawl.films]
    crawl = next((crawl for crawl in crawls if same_command(crawl.commanded, gait)), None)
    filmed = predict(samples, crawl.gait if crawl else gait, crawl.commanded if crawl else gait)
    band = filmed if crawl else predict(samples, gait)
    if band.exact_m_s <= 0.0:
        raise BadInput("one of the gaits does not move at all; choose a larger amplitude")
    ends = [
        (band.low_friction_m_s, band.high_friction_m_s),
        (band.low_joints_m_s, band.high_joints_m_s),
        (band.low_m_s, band.high_m_s),
        (filmed.low_m_s, filmed.high_m_s),
    ]
    slopes = np.linalg.solve(centred.T @ centred + ridge, centred.T @ band.samples_m_s[0])
    return slopes, np.diff(ends)[:, 0] / 2 / band.exact_m_s
