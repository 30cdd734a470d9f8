"""Sessions that are taken in memory alone, and truths for many of them: for studies and tests."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from serpenoid import Ground, ServoKind, Session
from serpenoid.session.declaration import Cells
from serpenoid.session.journal import Journal
from serpenoid.session.rows import kind_of, make_reading, reading_row
from serpenoid.session.session import Event
from serpenoid.session.settings import Setup
from serpenoid.session.track import Samples, Track
from serpenoid.taking.simulated import Truth


class MemoryRecord(Journal):
    """Keep readings as a journal does, but on no disk; begun: a session to be gone on with."""

    def __init__(self, setup: Setup, begun: Session | None = None):
        self.session = begun or Session(setup, ())
        self._count = max((r.number for r in self.session.readings), default=0)

    def add(
        self,
        kind: str,
        cells: Cells,
        *,
        replaces: int = 0,
        comment: str = "",
        samples: Samples | None = None,
    ) -> int:
        """Keep one reading; return its number. Parameters as for Journal.add."""
        self._count += 1
        common: dict[str, Any] = {"number": self._count, "comment": comment}
        if samples is not None:
            common["track"] = Track.from_samples(kind_of(kind).columns, samples)
        reading = make_reading(reading_row(kind, cells, self.session.setup.plan), common)
        if replaces:
            readings = (
                replace(r, voided=True) if r.number == replaces else r
                for r in self.session.readings
            )
            self.session = replace(self.session, readings=tuple(readings))
        self.session = self.session.with_reading(reading)
        return self._count

    def event(self, event: str, reading: int = 0, detail: str = "") -> None:
        """Keep one event."""
        event_row = Event("", event, reading, detail)
        self.session = replace(self.session, events=(*self.session.events, event_row))


def drawn_truth(
    setup: Setup, ground: Ground, rng: np.random.Generator, servo: ServoKind | None = None
) -> Truth:
    """Draw the errors that all readings of a session share, as the set-up says they may be.

    servo: the kind of which the robot has one drawn; None: its joints follow the gait.
    """
    errs = setup.instruments
    zero, scale, mass = (float(x) for x in rng.normal(size=3))
    return Truth(
        ground,
        incline_zero_rad=zero * errs.incline_zero_sigma_rad,
        belt_scale=1.0 + scale * errs.belt_scale_sigma,
        mass_scale=1.0 + mass * errs.mass_sigma,
        joint_sigma_rad=errs.joint_sigma_rad,
        servo=servo and servo.draws(1, int(rng.integers(2**31)))[0],
    )
