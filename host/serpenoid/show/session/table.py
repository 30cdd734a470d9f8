"""A session as tables: how far it is, and every reading with what became of it."""

from __future__ import annotations

import math
from typing import Any

from ...session.session import Session, belt_note
from .. import report

COLUMNS = "reading", "what", "values", "state", "comment"  # Heads, and keys of the JSON.


def rows(session: Session) -> list[list[str]]:
    """Return one row a reading: number, what, values, state; in the order of the numbers."""
    return [
        [str(r.number), *r.in_words(), "void" if r.voided else "", r.comment]
        for r in session.readings
    ]


def show(session: Session, parts: list[tuple[str, str]]) -> None:
    """Print what was read, then how far each part of the plan is."""
    report.table(session.setup.name, COLUMNS, rows(session), len(COLUMNS))
    for name, state in parts:
        report.console.print(f"{name:14} {state}")
    for note in notes(session):
        report.console.print(f"note: {note}", soft_wrap=True)


def notes(session: Session) -> list[str]:
    """Return what is to be told of a session's files, and of a belt that nobody checked."""
    return [*session.notes, *filter(None, [belt_note(session)])]


def as_dict(session: Session, parts: list[tuple[str, str]], say: str) -> dict[str, Any]:
    """Return the same as plain values."""
    zero = session.zero
    return {
        "name": session.setup.name,
        "parts": dict(parts),
        "next": say,
        "kept_stations": len(session.kept_stations),
        "kept_gait_runs": len(session.kept_gait_runs),
        "zero_deg": math.degrees(zero.value_rad),
        "zero_sigma_deg": math.degrees(zero.sigma_rad),
        "sha256": session.sha256,
        "readings": [dict(zip(COLUMNS, row, strict=True)) for row in rows(session)],
        "notes": notes(session),
    }
