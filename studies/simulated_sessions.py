"""Sessions that are taken in memory alone, and truths for many of them: for studies and tests."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from serpenoid import Ground, ServoKind, Session
from serpenoid.session.declaration import Cells
from serpenoid.session.folder import kind_of, make_reading, reading_row
from serpenoid.session.journal import Journal
from serpenoid.session.session import Event
from serpenoid.session.settings import Setup
from serpenoid.session.track import Samples, Track
from serpenoid.taking.simulated import Truth, wheel_inertia_kg

SHARED_ERRORS = {  # errors of a truth by where it is measured, and their sigmas, in draws' order
    "treadmill": {
        "incline_zero_rad": "incline_zero_sigma_rad",
        "belt_scale": "belt_scale_sigma",
        "mass_scale": "mass_sigma",
    },
    "floor": {
        "slope_rad": "floor_slope_sigma_rad",
        "film_scale": "film_scale_sigma",
        "mass_scale": "mass_sigma",
        "rolling_kg": "",
        "across_rad": "floor_slope_sigma_rad",
    },
}


class MemoryRecord(Journal):
    """Keep readings as a journal does, but on no disk; begun: a session to be gone on with."""

    def __init__(self, setup: Setup, begun: Session | None = None):
        self.session = begun or Session(setup, ())

    def add(
        self,
        kind: str,
        cells: Cells,
        *,
        replaces: int = 0,
        comment: str = "",
        samples: Samples | None = None,
    ) -> int:
        """Keep one reading; return its number. Parameters as for Journal.add; it replaces none."""
        number = len(self.session.readings) + 1
        common: dict[str, Any] = {"number": number, "comment": comment}
        if samples is not None:
            common["track"] = Track.from_samples(kind_of(kind).columns, samples)
        reading = make_reading(reading_row(kind, cells, self.session.setup.plan), common)
        self.session = self.session.with_reading(reading)
        return number

    def event(self, event: str, reading: int = 0, detail: str = "") -> None:
        """Keep one event."""
        events = *self.session.events, Event(event, reading, detail)
        self.session = replace(self.session, events=events)


def drawn_truth(
    setup: Setup, ground: Ground, rng: np.random.Generator, servo: ServoKind | None = None
) -> Truth:
    """Draw the errors that all readings of a session share, as the set-up says they may be.

    servo: the kind of which the robot has one drawn; None: its joints follow the gait.
    """
    errors = dict[str, Any]()
    for name, sigma in SHARED_ERRORS[setup.plan.on].items():
        sigmas = rng.normal()
        errors[name] = wheel_inertia_kg(setup, sigmas)
        if sigma:
            errors[name] = name.endswith("scale") + sigmas * getattr(setup.instruments, sigma)
    errors["servo"] = servo and servo.draws(1, int(rng.integers(2**31)))[0]
    return Truth(ground, joint_sigma_rad=setup.instruments.joint_sigma_rad, **errors)
