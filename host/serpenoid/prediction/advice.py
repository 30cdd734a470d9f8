"""Rank the readings that could be taken next by how much they narrow the predicted speed bands.

Each candidate is added to the session at its expected value. The linearised posterior then gives
the covariance that friction would have with it.

Candidates are stations on a treadmill or pushes on a floor, a film if the session has films or
tags, and a bench test if the servo was not measured. Stations that repeat a voided one, need a
faster belt than the plan allows, or are steeper than both home treadmills and the steepest station
taken are left out.
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
from .next_readings import MINUTES, NextReading, next_pushes, next_stations
from .speeds import SAMPLES, Progress, Samples, draw_samples, predict

MIN_REDUCTION = 0.1  # Relative reduction of the band that makes a reading worth its time.
# Share of the servos' contribution to the band that remains after a bench test of one joint.
TESTED_SERVO_SHARE = 0.5


@dataclass(frozen=True)
class Advice(Result):
    """Hold the present speed band and the readings that would narrow it.

    Attributes
    ----------
    gaits
        The gaits whose speeds count.
    band
        Half width of the 95 % speed band over the speed, mean over the gaits, from the same samples
        as `compare`.
    readings
        Readings that can be taken next, first the one with the largest reduction a minute.
    note
        Remark for the user, or "".
    servo
        Name of the kind of servo; None for joints that follow the gait.
    fit_alarms
        Reasons not to trust the friction fit behind the bands.

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
        """Return the reading that reduces the band most a minute."""
        return self.readings[0]

    @property
    def worth(self) -> bool:
        """Return whether any reading makes the band at least a tenth narrower."""
        return any(reading.band <= (1.0 - MIN_REDUCTION) * self.band for reading in self.readings)

    def in_words(self) -> str:
        """Return which reading to take, or that none is worth its time."""
        best, present = self.best, f"±{100 * self.band:.2g} %"
        text = (
            f"Take next: {best.words} ({best.minutes:.0f} minutes); the speed is then known to "
            f"±{100 * best.band:.2g} %, now {present}."
            if self.worth
            else "No further reading is worth its time: none makes the 95 % band of the speed, "
            f"{present}, a tenth narrower."
        )
        return f"{text} {self.note}".strip()

    def table(self, verbose: bool = True) -> tuple[list[str], list[list[str]]]:
        """Return heads and rows of the best readings; none if no reading is worth its time."""
        if not self.worth:
            return [], []
        cells = [
            [reading.words, f"{reading.minutes:.0f}", f"±{reading.band:.1%}"]
            for reading in self.readings[:5]
        ]
        return ["reading", "minutes", "speed then known to"], cells

    def to_dict(self) -> dict[str, Any]:
        """Return the attributes by name for JSON; fit_alarms only if there are any."""
        values = asdict(self)
        alarms = values.pop("fit_alarms")
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
    """Rank the readings that could be taken next by the reduction of the speed band a minute.

    Parameters
    ----------
    session
        The readings so far.
    gaits
        The gaits whose speeds count: the planned ones unless given; the note names too fast ones.
    samples
        Number of frictions sampled from the fit.
    servo
        The kind of servo that moves the joints, as for `compare`.
    progress
        Function called with the share of the gaits done, 0 to 1.

    Returns
    -------
    Advice
        The present band, and the readings, best first.

    Raises
    ------
    BadInput
        If the session has no reading yet, the servo can follow none of the gaits, or the readings
        do not determine friction.

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
        raise BadInput(f"{session.where}: there is no station and no push; take one first")
    fit, estimate = fit_friction(session), map_estimate(session)
    servo = servo and driving(session.setup, servo)
    too_fast = [too_fast_text(gait, servo, gait_name(gait)) for gait in asked_gaits]
    feasible = tuple(gait for gait, text in zip(asked_gaits, too_fast, strict=True) if not text)
    if not feasible:
        raise BadInput(
            f"{session.where}: {' '.join(too_fast)} So no speed has a band to make narrower; name "
            "a slower gait"
        )
    drawn, parts = draw_samples(fit, servo, count=samples), list[tuple[Array, Array]]()
    for gait in feasible:
        parts.append(_slopes_and_half_widths(session, drawn, gait))
        if progress is not None:
            progress(len(parts) / len(feasible))
    slopes, half_widths = map(np.array, zip(*parts, strict=True))
    by_friction, by_joints, complete, filmed = half_widths.T
    present_band = float(complete.mean())
    other_variance = np.maximum(complete**2 - by_friction**2, 0.0)

    def variance(*more: Any) -> Array:
        """Return the variance (gaits,) of the speeds due to friction, given more readings."""
        number = 1 + max(reading.number for reading in session.readings)
        expected = (replace(reading, number=number) for reading in more)
        extended = replace(session, readings=(*session.readings, *expected))
        return np.einsum("gi,ij,gj->g", slopes, covariance_after(extended, estimate), slopes)

    present_variance, readings = variance(), list[NextReading]()
    candidates = next_pushes(session) if session.on_floor else next_stations(session, estimate)
    for candidate, more in candidates:
        friction_variance = by_friction**2 * variance(*more) / present_variance
        band = float(np.sqrt(other_variance + friction_variance).mean())
        readings.append(replace(candidate, band=band))
    if servo is not None and not servo.drawn and not servo.exact:
        words = "a bench test of one joint (`serpenoid servo --test`)"
        by_joints = np.minimum(by_joints, complete)
        servo_variance = TESTED_SERVO_SHARE**2 * (complete**2 - by_joints**2)
        band = float(np.sqrt(by_joints**2 + servo_variance).mean())
        readings.append(NextReading("servo", words, MINUTES.servo_test, band))
    by_film = any(push.source == "film" for push in session.kept_pushes)
    if by_film or session.kept_films or session.setup.robot_table.tag_side_m:
        words = "a film of the crawling robot (`serpenoid video`)"
        minutes = MINUTES.film * len(feasible)
        readings.append(NextReading("film", words, minutes, float(filmed.mean())))
    if not readings:
        raise BadInput(
            f"{session.where}: no further station is possible at the plan's belt speeds; raise "
            "belt_speed_max_m_s in the plan"
        )
    # Readings that are worth their time come first, whatever the others reduce a minute.
    worth_band = (1.0 - MIN_REDUCTION) * present_band
    readings.sort(key=lambda r: (r.band > worth_band, (r.band - present_band) / r.minutes))
    note = " ".join(filter(None, [servo.remark if servo else "", *too_fast]))
    return Advice(feasible, present_band, tuple(readings), note, servo and servo.name, fit.alarms)


def _slopes_and_half_widths(session: Session, samples: Samples, gait: Gait) -> tuple[Array, Array]:
    """Return the derivatives (4,) of a gait's speed by the frictions, and half widths (4,).

    The derivatives come from a linear regression over the sampled speeds. The half widths are those
    of four 95 % bands over the speed: with uncertain friction; with the joints' amplitude too; with
    the servos too; and with friction and the joints' motion as filmed. Raises BadInput for a gait
    that does not move the robot.
    """
    centred = samples.frictions - samples.frictions.mean(axis=0)
    # The ridge keeps the regression determined where a friction is known almost exactly.
    ridge = 1e-6 * len(centred) * np.diag(np.diag(samples.fit.covariance))
    crawl = next(
        (
            crawl
            for crawl in crawls_by_command(session)
            if crawl.films and same_command(crawl.commanded, gait)
        ),
        None,
    )
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
