"""A session that is taken in memory alone, for studies of many of them."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from ..kinds.declaration import Cells
from ..kinds.rows import kind_of, make_reading, reading_row
from ..kinds.tracks import Samples, Track
from ..session import Session, Setup
from ..session_rows import Event


class MemoryRecord:
    """Keep readings as a journal does, but on no disk; begun: a session to be gone on with."""

    def __init__(self, setup: Setup, begun: Session | None = None):
        self.session = begun or Session(setup, ())
        self.events: list[Event] = []
        self._count = max((r.number for _, r in self.session.numbered), default=0)

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
            common["track"] = Track.of(kind_of(kind).track, samples)
        made = make_reading(reading_row(kind, cells, self.session.setup.procedure), common)
        if replaces:
            part = kind_of(kind).part or "further"
            kept = [
                replace(r, voided=r.voided or r.number == replaces)
                for r in getattr(self.session, part)
            ]
            self.session = replace(self.session, **{part: tuple(kept)})
        self.session = self.session.with_reading(kind_of(kind), made)
        return self._count

    def event(self, event: str, reading: int = 0, detail: str = "") -> None:
        """Keep one event."""
        self.events.append(Event("", event, reading, detail))
