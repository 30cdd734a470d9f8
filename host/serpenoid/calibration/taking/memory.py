"""A session that is taken in memory alone, for studies of many of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from ..session import BendCheck, GaitRun, Reading, Session, Setup, ZeroReading
from ..session_rows import Event, make
from .journal import reading_row

_PARTS = {Reading: "readings", GaitRun: "gait_runs", ZeroReading: "zeros", BendCheck: "bends"}


class MemoryRecord:
    """Keep readings as a journal does, but on no disk; begun: a session to be gone on with."""

    def __init__(self, setup: Setup, begun: Session | None = None):
        self.session = begun or Session(setup, ())
        self.events: list[Event] = []
        parts = (getattr(self.session, part) for part in _PARTS.values())
        self._count = max((r.number for part in parts for r in part), default=0)

    def add(
        self, kind: str, cells: Mapping[str, float | str], *, replaces: int = 0, comment: str = ""
    ) -> int:
        """Keep one reading; return its number. cells as for Journal.add."""
        self._count += 1
        made: Any = make(reading_row(kind, cells), {"number": self._count, "comment": comment})
        if isinstance(made, ZeroReading):
            made = replace(made, before=not self.session.readings)
        part = _PARTS[type(made)]
        kept = [replace(r, voided=r.voided or r.number == replaces)
                for r in getattr(self.session, part)]  # fmt: skip
        self.session = replace(self.session, **{part: (*kept, made)})
        return self._count

    def event(self, event: str, reading: int = 0, detail: str = "") -> None:
        """Keep one event."""
        self.events.append(Event("", event, reading, detail))
