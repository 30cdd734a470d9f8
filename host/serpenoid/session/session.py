"""A calibration session in memory: the set-up, and every kind of reading taken under it.

Everything here is SI and radians; `folder` reads it from a folder, whose files speak degrees.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections import Counter
from dataclasses import dataclass, replace
from pathlib import Path
from statistics import mean
from typing import Any, NamedTuple

import numpy as np

from ..base.checks import count_text
from .gait_run import Crawl, FilmReading, GaitRun
from .push import Push
from .settings import Setup
from .station import Reading, ZeroReading, bent_share

NO_BELT = "The belt's speed was not checked"


class Zero(NamedTuple):
    """What is known of the inclinometer's zero: to be taken off every incline it shows.

    moved_sigmas: how far it moved from before to after, in that difference's own errors.
    """

    value_rad: float
    sigma_rad: float
    readings: int = 0
    moved_sigmas: float = 0.0


@dataclass(frozen=True, slots=True)
class Event:
    """One line of events.csv; reading is 0 where none is meant."""

    event: str
    reading: int
    detail: str


@dataclass(frozen=True, slots=True)
class Session:
    """Hold a set-up and its readings in the order they were taken, voided ones included.

    Attributes
    ----------
    setup
        The robot, the instruments and the plan.
    readings
        What was measured, of every kind, by their numbers.
    where
        The session's name in errors: the readings' file if there is one.
    folder
        The session's folder; None for a session in memory.
    notes
        Remarks from reading the files, in words.
    events
        What happened meanwhile: amendments, pauses, steps that were left out.

    Examples
    --------
    >>> session = sn.load_session("calibration_data/nirakh-2005")
    >>> session.setup.robot.links
    6
    >>> print(session)
    nirakh-2005: 11 stations
    """

    setup: Setup
    readings: tuple[Any, ...]
    where: str = "session"
    folder: Path | None = None
    notes: tuple[str, ...] = ()
    events: tuple[Event, ...] = ()

    def __str__(self) -> str:
        """Return the session's name, and how many readings of each kind it has."""
        counts = Counter("void reading" if r.voided else r.kind for r in self.readings)
        words = ", ".join(count_text(number, name) for name, number in counts.items())
        return f"{self.setup.name}: {words or 'no reading yet'}"

    @property
    def kept_stations(self) -> tuple[Reading, ...]:
        """Return the stations that were not voided."""
        return self.kept_of("station")

    @property
    def kept_gait_runs(self) -> tuple[GaitRun, ...]:
        """Return the gait runs that were not voided."""
        return self.kept_of("gait")

    @property
    def kept_films(self) -> tuple[FilmReading, ...]:
        """Return the measured films that were not voided."""
        return self.kept_of("video")

    @property
    def kept_crawls(self) -> tuple[Crawl, ...]:
        """Return the gait runs and the films that were not voided."""
        return (*self.kept_gait_runs, *self.kept_films)

    @property
    def kept_pushes(self) -> tuple[Push, ...]:
        """Return the pushes along a floor that were not voided."""
        return self.kept_of("push")

    @property
    def fitted(self) -> tuple[Reading | Push, ...]:
        """Return what a friction fit rests on, in the order of its residuals."""
        return (*self.kept_stations, *self.kept_pushes)

    @property
    def on_floor(self) -> bool:
        """Tell whether there are readings for the fit that were not taken on a treadmill."""
        return bool(self.kept_pushes)

    @property
    def skipped(self) -> frozenset[str]:
        """Return the keys of all steps that were left out, and not taken up again."""
        keys: set[str] = set()
        for e in self.events:
            if e.event == "skip":
                keys.add(e.detail)
            elif e.event == "unskip":
                keys.discard(e.detail)
        return frozenset(keys)

    def readings_of(self, kind: str) -> tuple[Any, ...]:
        """Return all readings of a kind, by its name."""
        return tuple(r for r in self.readings if r.kind == kind)

    def kept_of(self, kind: str) -> tuple[Any, ...]:
        """Return the readings of a kind that were not voided."""
        return tuple(r for r in self.readings_of(kind) if not r.voided)

    def with_reading(self, reading: Any) -> Session:
        """Return the session with one more reading; a zero knows of stations before it."""
        if isinstance(reading, ZeroReading):
            reading = replace(reading, at_start=not self.readings_of("station"))
        return replace(self, readings=(*self.readings, reading))

    @property
    def belt_scale(self) -> tuple[float, float]:
        """Return the belt's true speed over the one shown, and its standard deviation.

        The mean of the checks by mark and stopwatch and of what any belt may be: 1 within 7 %, or
        within what the instruments state where that is more. Readings that were regenerated from
        published fits, whose belt nobody can check, are taken as their instruments state.
        """
        stated = self.setup.instruments.belt_scale_sigma
        if self.setup.provenance.kind != "regenerated":
            stated = max(stated, 0.07)
        checks = [(1.0, stated)] * bool(stated) + belt_checks(self)
        if not checks:
            return 1.0, 0.0
        scales, sigmas = np.transpose(checks)
        weights = np.maximum(sigmas, 1e-6) ** -2.0
        return float(np.average(scales, weights=weights)), float(weights.sum() ** -0.5)

    @property
    def zero(self) -> Zero:
        """Return the inclinometer's zero and its standard deviation.

        Measured by reversal: the mean, with what two readings' errors leave and with half of what
        it moved between before and after. Not measured: 0, with what the set-up declares.
        """
        tools, zeros = self.setup.instruments, self.kept_of("zero")
        sides = [[z.zero_rad for z in zeros if z.at_start is side] for side in (True, False)]
        sides = [side for side in sides if side]
        if not sides:
            return Zero(0.0, tools.incline_zero_sigma_rad)
        means = [mean(side) for side in sides]
        moved_rad = abs(means[-1] - means[0])
        sigma_rad = tools.incline_sigma_rad / math.sqrt(2)  # sigma of one zero, two readings halved
        difference_rad = sigma_rad * math.sqrt(sum(1 / len(side) for side in sides))
        off_rad = math.hypot(sigma_rad / math.sqrt(len(zeros)), moved_rad / 2)
        return Zero(mean(means), off_rad, len(zeros), moved_rad / difference_rad)

    def bent_share(self, reading: Reading | Push) -> float:
        """Return which share of the links stands at lambda in a reading; 0 where straight."""
        if not reading.lambda_rad:
            return 0.0
        return bent_share(reading.bend, self.setup.robot.links)

    @property
    def sha256(self) -> str:
        """Return a hash of all that a friction fit rests on: robot, gravity, zeros, readings."""
        setup = self.setup
        readings = [r for r in self.readings if r.fitted and not r.voided]
        rests_on = [
            repr(setup.robot),
            repr(setup.instruments),
            setup.laboratory.gravity_m_s2,
            setup.robot_table.wheels_kg,
            setup.mass_sigma,
            *map(repr, readings),
        ]
        return hashlib.sha256(json.dumps(rests_on).encode()).hexdigest()


def belt_checks(session: Session) -> list[tuple[float, float]]:
    """Return the belt's true speed over the one shown, and its sigma, of each timed mark."""
    tools = session.setup.instruments
    return [(check.scale, check.scale_sigma(tools)) for check in session.kept_of("belt")]


def belt_note(session: Session) -> str:
    """Return in words that a session's belt was never checked; "" where it was, or none ran."""
    if (
        not session.kept_stations
        or belt_checks(session)
        or session.setup.provenance.kind == "regenerated"
    ):
        return ""
    return (
        f"{NO_BELT}: it is taken to run as it shows, within {session.belt_scale[1]:.0%}, and "
        "ct and cn are as unsure. Time ten turns of a mark on it: `serpenoid calibrate add DIR "
        "belt belt_speed_m_s=0.5 distance_m=28 duration_s=56`."
    )
