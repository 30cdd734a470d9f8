"""Format 2: readings of every kind and events, one line each, read as an append-only journal.

A line that has no end was cut short while it was written (a kill, a power cut) and does not
count; the writer later closes it with the mark TORN. Lines are never changed: a reading is voided,
restored or amended by an event, and redone by a later reading that says which one it replaces.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from datetime import datetime
from pathlib import Path
from typing import Any

from ..model.checks import check_choice
from ..model.errors import BadInput
from ..model.files import csv_rows, read_text
from ..model.toml_table import check_names, located
from .kinds.declaration import Taken
from .kinds.rows import DOUBTFUL, KINDS, READING_COLUMNS, TRACK_WORDS, Row, make_reading, words_of
from .kinds.tracks import FOLDER, Track, read_track
from .session import Session, Setup
from .settings import amended

TORN = "#torn"
EVENT_COLUMNS = ("time_utc", "event", "reading", "detail")
EVENTS = (
    "start",
    "end",
    "pause",
    "resume",
    "amend",
    "void",
    "restore",
    "undo",
    "skip",
    "unskip",
    "note",
    "connect",
)


@dataclass(frozen=True)
class Event:
    """One line of events.csv; reading is 0 where none is meant."""

    time_utc: str
    event: str
    reading: int
    detail: str


@dataclass
class _Found:
    """What the lines have told so far."""

    rows: dict[int, tuple[Row, str]] = field(default_factory=dict)
    voided: dict[int, str] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)


def read_format_2(setup: Setup, folder: Path) -> Session:
    """Return the session of a folder."""
    path = folder / "readings.csv"
    found = _Found()
    setups = [setup]
    events = read_events(folder, found.notes)
    for event in events:
        if event.event == "amend":
            setups.append(amended(setups[-1], event.detail, folder))
    for row, where in _rows(path, READING_COLUMNS, found.notes):
        with located(where):
            _take(row, where, found)
    for event in events:
        _apply(event, found, folder / "events.csv")
    return _session(setups, found, folder)


def read_events(folder: Path, notes: list[str] | None = None) -> list[Event]:
    """Return a session's events in the order they were written; raises BadInput."""
    path = folder / "events.csv"
    found = []
    for row, where in _rows(path, EVENT_COLUMNS, [] if notes is None else notes):
        with located(where):
            event = check_choice("event", row["event"], EVENTS)
            number = whole_number("reading", row["reading"]) if row["reading"] else 0
            found.append(Event(time_of(row["time_utc"]), event, number, row["detail"]))
    return found


def events_of(session: Session) -> list[Event]:
    """Return the events of a session's folder; none of one in memory or of format 1."""
    folder = session.folder
    return read_events(folder) if folder and (folder / "events.csv").exists() else []


def _rows(path: Path, columns: tuple[str, ...], notes: list[str]) -> Iterator[tuple[Row, str]]:
    """Yield the whole lines below the header as dictionaries, and where each stands."""
    text = _text(path, columns)
    lines = text.split("\n")
    if lines[-1].strip():
        notes.append(
            f"{path}:{len(lines)}: the last line has no end: it was cut short while it was "
            "written, and does not count"
        )
    header = _cells(lines[0]) if len(lines) > 1 else []
    if len(header) == 1 and ";" in lines[0]:
        raise BadInput(
            f"{path}:1: the cells are parted by semicolons; a spreadsheet did that: save the file "
            "as CSV with commas, and decimals with a point"
        )
    check_names(header, columns, f"{path}:1", "column")
    for number, line in enumerate(lines[1:-1], 2):
        where = f"{path}:{number}"
        if not line.strip() or line.endswith(TORN):
            continue
        if "\0" in line:
            notes.append(f"{where}: damaged (zero bytes, as after a power cut), and does not count")
            continue
        with located(where):
            yield _row(header, line), where


def _text(path: Path, columns: tuple[str, ...]) -> str:
    """Return the text of one of a session's files, which is there and has its first line."""
    backup = f"take it from a backup; if there is none, its first line is {','.join(columns)}"
    if not path.exists():
        raise BadInput(f"{path}: not there, but it belongs to the session; {backup}")
    text = read_text(path)
    if not text.strip():
        raise BadInput(f"{path}: the file is empty; {backup}")
    return text


def _cells(line: str) -> list[str]:
    return next(iter(csv_rows(line.rstrip("\r"))), [])


def _row(header: list[str], line: str) -> Row:
    cells = _cells(line)
    if len(cells) != len(header):
        raise BadInput(
            f"{len(cells)} cells where the header has {len(header)}; decimals take a point, not a "
            f"comma; a line that is beyond repair is left out if it ends in {TORN}"
        )
    return {name: cell.strip() for name, cell in zip(header, cells, strict=True)}


def _take(row: Row, where: str, found: _Found) -> None:
    number = whole_number("reading", row["reading"])
    if number in found.rows:
        raise BadInput(
            f"reading {number} is there already, at {found.rows[number][1]}; give a new reading a "
            "new number, and name in `replaces` the one it replaces"
        )
    if row["replaces"]:
        old = whole_number("replaces", row["replaces"])
        if old not in found.rows:
            raise BadInput(f"replaces is {old}, but there is no such reading before this one")
        found.voided[old] = f"redone as {number}"
    if DOUBTFUL in words_of(row):
        found.voided[number] = ""  # its comment says why
    _check_clock(row, where, found)
    found.rows[number] = row, where


def _check_clock(row: Row, where: str, found: _Found) -> None:
    time_of(row["time_utc"])
    earlier = next((r["time_utc"] for r, _ in reversed(found.rows.values()) if r["time_utc"]), "")
    if row["time_utc"] and row["time_utc"] < earlier:
        found.notes.append(
            f"{where}: the clock went back, from {earlier} to {row['time_utc']}; the order of the "
            "lines counts"
        )


def _apply(event: Event, found: _Found, path: Path) -> None:
    if event.event not in ("void", "restore", "undo"):
        return
    if event.reading not in found.rows:
        raise BadInput(f"{path}: {event.event} of reading {event.reading}, which is not there")
    if event.event == "restore":
        if not _replaced_later(event, found):
            found.voided.pop(event.reading, None)
        return
    found.voided[event.reading] = event.detail or "undone"
    replaced = found.rows[event.reading][0]["replaces"]
    if event.event == "undo" and replaced:
        found.voided.pop(int(replaced), None)


def _replaced_later(restored: Event, found: _Found) -> bool:
    """Tell whether a reading was taken anew after it was restored: then the new one counts."""
    after = re.fullmatch(r"after reading (\d+)", restored.detail)
    return after is not None and any(
        row["replaces"] == str(restored.reading) and number > int(after[1])
        for number, (row, _) in found.rows.items()
    )


def _session(setups: list[Setup], found: _Found, folder: Path) -> Session:
    session = Session(setups[-1], (), str(folder / "readings.csv"), folder=folder)
    unknown: list[str] = []
    for row, where in found.rows.values():
        kind = KINDS.get(row["kind"])
        if kind is None:
            unknown.append(row["kind"])
            continue
        with located(where):
            reading = make_reading(row, _common(row, found) | _track(row, kind, folder))
            reading = _with_instruments(reading, _setup_of(row, setups))
            session = session.with_reading(reading)
    if unknown:
        kinds = ", ".join(sorted(set(unknown)))
        found.notes.append(f"{len(unknown)} reading(s) of kinds not used here ({kinds}) left out")
    return replace(session, notes=tuple(found.notes))


def _with_instruments(reading: Any, setup: Setup) -> Any:
    """Return a reading that keeps the instruments it was taken with, whatever is amended later."""
    of = {"uncertainty": setup.uncertainty, "treadmill": setup.treadmill, "watch": setup.stopwatch}
    return replace(reading, **{name: tool for name, tool in of.items() if hasattr(reading, name)})


def _track(row: Row, kind: type[Taken], folder: Path) -> dict[str, Track]:
    """Return the track of a reading whose kind has one."""
    if not kind.columns:
        return {}
    said = words_of(row)
    name, sha256 = (said.get(word, "") for word in TRACK_WORDS)
    if not name and kind.track_may_miss:
        return {}
    if not re.fullmatch(rf"{FOLDER}/\w+\.csv", name):
        raise BadInput(f"track is {name!r}; it must be a file such as {FOLDER}/0001.csv")
    return {"track": read_track(folder / name, kind.columns, sha256)}


def _setup_of(row: Row, setups: list[Setup]) -> Setup:
    number = whole_number("setup", row["setup"])
    if number > len(setups):
        raise BadInput(
            f"setup is {number}, but events.csv tells of {len(setups) - 1} amendment(s), so the "
            f"last is {len(setups)}; has a line been taken out of events.csv?"
        )
    return setups[number - 1]


def _common(row: Row, found: _Found) -> dict[str, Any]:
    number = int(row["reading"])
    why = found.voided.get(number)
    comment = row["comment"] if why is None else "; ".join(filter(None, [why, row["comment"]]))
    return {
        "number": number,
        "voided": why is not None,
        "comment": comment,
        "time_utc": row["time_utc"],
    }


def reading_rows(folder: Path) -> list[Row]:
    """Return the rows of all readings there are, of whatever kind, voided or not."""
    return [row for row, _ in _rows(folder / "readings.csv", READING_COLUMNS, [])]


def whole_number(name: str, text: str) -> int:
    """Return a cell's whole number from 1, or raise BadInput."""
    if not re.fullmatch("[1-9][0-9]{0,8}", text):
        raise BadInput(f"{name} is {text!r}; it must be a whole number from 1")
    return int(text)


def time_of(text: str) -> str:
    """Return a time as it stands if it is ISO 8601 or empty, else raise BadInput."""
    try:
        if text:
            datetime.fromisoformat(text.removesuffix("Z"))
    except ValueError:
        raise BadInput(f"time_utc is {text!r}; it must be ISO 8601 or empty") from None
    return text
