"""Readings of every kind and events, one line each, read as an append-only journal.

A line that has no end was cut short while it was written (a kill, a power cut) and does not
count; the writer later closes it with the mark TORN. Lines are never changed: a reading is voided,
or used again (`restore`, of older versions) by an event, and a later reading may say which one it
replaces.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import replace
from datetime import datetime
from pathlib import Path

from ..base.checks import check_choice
from ..base.errors import BadInput
from ..base.files import csv_rows, read_text
from ..base.toml_table import check_names, located
from .declaration import Taken
from .kinds import (
    DOUBTFUL,
    KINDS,
    OLD_KINDS,
    READING_COLUMNS,
    TRACK_WORDS,
    Row,
    make_reading,
    words_of,
)
from .session import Event, Session
from .settings import Setup, amendment
from .track import FOLDER, Track, read_track

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
ON_READINGS = ("void", "restore", "undo")
INCLINED = ("station", "zero")  # kinds whose errors these instruments state
SHOWN = {
    "incline_sigma_deg",
    "incline_zero_sigma_deg",
    "belt_speed_sigma_m_s",
    "lambda_sigma_deg",
    "belt_scale_sigma_percent",
    "joint_sigma_deg",
    "incline_step_percent",
}
TIMED = {"distance_sigma_m", "time_sigma_s"}  # of belt checks and of places over time
Numbered = dict[int, Row]  # rows by the numbers of their readings


def session_of(setup: Setup, events: Sequence[Event], folder: Path, notes: list[str]) -> Session:
    """Return the session of a folder. notes: what is told of its files so far."""
    path, notes = folder / "readings.csv", list(notes)
    later = [_keys(event.detail, folder) for event in events if event.event == "amend"]
    if any(later):
        named = ", ".join(sorted(set().union(*later)))
        notes.append(
            f"{named}: amended in events.csv by an older program; that holds over session.toml"
        )
    rows = _numbered(path, notes)
    voided = _voided(rows, events, folder / "events.csv")
    session = Session(setup, (), str(path), folder=folder, events=tuple(events))
    left_out = Counter[str]()
    for number, row in rows.items():
        kind = KINDS.get(row["kind"])
        if kind is None or words_of(row).get("by") == "marks":
            left_out[row["kind"] if kind is None else f"{row['kind']} by marks"] += 1
            continue
        comment = "; ".join(filter(None, (voided.get(number), row["comment"])))
        common = {"number": number, "voided": number in voided, "comment": comment}
        common |= {"time_utc": row["time_utc"]}
        with located(row["where"]):
            under = _setup_number(row, len(later))
            if number not in voided:
                _check_instruments(row, set().union(*later[under - 1 :]))
                _check_facing(row)
            session = session.with_reading(make_reading(row, common | _track(row, kind, folder)))
    if left_out:
        kinds = ", ".join(sorted(left_out))
        notes.append(f"{left_out.total()} reading(s) of kinds not used here ({kinds}) left out")
    return replace(session, notes=tuple(notes))


def _keys(detail: str, folder: Path) -> set[str]:
    """Return the settings that an amendment changes."""
    tables = amendment(detail, folder / "events.csv")
    return {key for table in tables.values() for key in table}


def read_events(folder: Path, notes: list[str]) -> list[Event]:
    """Return a session's events in the order they were written; raises BadInput."""
    events = []
    for row in rows_in(folder / "events.csv", EVENT_COLUMNS, notes):
        with located(row["where"]):
            event = check_choice("event", row["event"], EVENTS)
            number = whole_number("reading", row["reading"]) if row["reading"] else 0
            events.append(Event(time_of(row["time_utc"]), event, number, row["detail"]))
    return events


def reading_rows(folder: Path) -> Numbered:
    """Return the rows of all readings by their numbers, of whatever kind, voided or not."""
    return _numbered(folder / "readings.csv", [])


def rows_in(path: Path, columns: tuple[str, ...], notes: list[str]) -> Iterator[Row]:
    """Yield the lines below the header by their columns, `where` each stands too; raises BadInput.

    notes: takes what is told of lines that do not count.
    """
    backup = f"take it from a backup; if there is none, its first line is {','.join(columns)}"
    if not path.exists():
        raise BadInput(f"{path}: not there, but it belongs to the session; {backup}")
    text = read_text(path)
    if not text.strip():
        raise BadInput(f"{path}: the file is empty; {backup}")
    lines = text.split("\n")
    if lines[-1].strip():
        notes.append(
            f"{path}:{len(lines)}: the last line has no end: it was cut short while it was "
            "written, and does not count"
        )
    with located(f"{path}:1"):
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
            yield {**_row(header, line), "where": where}


def _cells(line: str) -> list[str]:
    return next(iter(csv_rows(line)), [])


def _row(header: list[str], line: str) -> Row:
    cells = _cells(line)
    if len(cells) != len(header):
        raise BadInput(
            f"{len(cells)} cells where the header has {len(header)}; decimals take a point, not a "
            f"comma; a line that was cut short is left out if it ends in {TORN}"
        )
    return {name: cell.strip() for name, cell in zip(header, cells, strict=True)}


def _numbered(path: Path, notes: list[str]) -> Numbered:
    """Return the rows by number, each checked against those before it; raises BadInput."""
    rows: Numbered = {}
    latest = ""
    for row in rows_in(path, READING_COLUMNS, notes):
        with located(row["where"]):
            number = whole_number("reading", row["reading"])
            if number in rows:
                raise BadInput(
                    f"reading {number} is there already, at {rows[number]['where']}; give a new "
                    "reading a new number, and name in `replaces` the one it replaces"
                )
            if row["replaces"] and whole_number("replaces", row["replaces"]) not in rows:
                raise BadInput(
                    f"replaces is {row['replaces']}, but there is no such reading before this one"
                )
            if row["time_utc"] and time_of(row["time_utc"]) < latest:
                notes.append(
                    f"{row['where']}: the clock went back, from {latest} to {row['time_utc']}; the "
                    "order of the lines counts"
                )
            latest = row["time_utc"] or latest
        rows[number] = {**row, "kind": OLD_KINDS.get(row["kind"], row["kind"])}
    return rows


def _voided(rows: Numbered, events: Sequence[Event], path: Path) -> dict[int, str]:
    """Return the readings that are not to be used, and why; raises BadInput."""
    why: dict[int, str] = {}
    for number, row in rows.items():
        if row["replaces"]:
            why[int(row["replaces"])] = f"redone as {number}"
        if DOUBTFUL in words_of(row):
            why[number] = ""  # its comment says why
    for event in (e for e in events if e.event in ON_READINGS):
        if event.reading not in rows:
            raise BadInput(f"{path}: {event.event} of reading {event.reading}, which is not there")
        if event.event != "restore":
            why[event.reading] = event.detail or "undone"
            replaced = rows[event.reading]["replaces"]
            if event.event == "undo" and replaced:
                why.pop(int(replaced), None)
        elif not _replaced_later(event, rows):
            why.pop(event.reading, None)
    return why


def _replaced_later(restored: Event, rows: Numbered) -> bool:
    """Tell whether a reading was taken anew after it was restored: then the new one counts."""
    after = re.fullmatch(r"after reading (\d+)", restored.detail)
    return after is not None and any(
        row["replaces"] == str(restored.reading) and number > int(after[1])
        for number, row in rows.items()
    )


def _check_facing(row: Row) -> None:
    """Raise BadInput for a reading of wheels that rolled backwards, as older programs took them."""
    facing = words_of(row).get("facing", "")
    if facing in ("up", "back"):
        raise BadInput(
            f"reading {row['reading']} has facing={facing}: its wheels rolled backwards, and a fit "
            "knows one friction along the wheels. If they roll alike both ways, take that word out "
            "of its line; else void the reading"
        )


def _check_instruments(row: Row, changed: set[str]) -> None:
    """Raise BadInput if instruments that a reading was taken with were amended after it."""
    timed = row["kind"] == "belt" or "places" in words_of(row)
    used = (SHOWN if row["kind"] in INCLINED else set()) | (TIMED if timed else set())
    if used & changed:
        raise BadInput(
            f"reading {row['reading']} was taken with other instruments: a session has one set of "
            "instruments. Begin a new session for others; correct in session.toml what was "
            "mistyped there"
        )


def _track(row: Row, kind: type[Taken], folder: Path) -> dict[str, Track]:
    """Return the track of a reading whose kind has one."""
    name, sha256 = (words_of(row).get(word, "") for word in TRACK_WORDS)
    if not kind.columns or (not name and kind.track_may_miss):
        return {}
    if not re.fullmatch(rf"{FOLDER}/\w+\.csv", name):
        raise BadInput(f"track is {name!r}; it must be a file such as {FOLDER}/0001.csv")
    return {"track": read_track(folder / name, kind.columns, sha256)}


def _setup_number(row: Row, amendments: int) -> int:
    """Return under which set-up a reading was taken: 1, and one more for each amendment."""
    number = whole_number("setup", row["setup"])
    if number > amendments + 1:
        raise BadInput(
            f"setup is {number}, but events.csv tells of {amendments} amendment(s), so the "
            f"last is {amendments + 1}; has a line been taken out of events.csv?"
        )
    return number


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
