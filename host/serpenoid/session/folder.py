"""A session's folder: session.toml says how, readings.csv what was read, events.csv what happened.

Files are read strictly. They speak degrees, as people type them; the session speaks SI. Readings
of every kind and events are lines of an append-only journal.
A line that has no end was cut short while it was written (a kill, a power cut) and does not
count; the writer later closes it with the mark TORN. Lines are never changed: a reading is voided,
or used again (`restore`, of older versions) by an event; a later one may say which it replaces.
A column that the header lacks stands in the column `more` as NAME=VALUE, so that files of every age
have the same header and older programs still read them.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from ..base.checks import check_choice, count_text
from ..base.errors import BadInput
from ..base.files import csv_rows, read_text
from ..base.toml_table import Table, check_names, located
from .declaration import Cells, Observation
from .gait_run import FilmReading, GaitRun
from .push import Push
from .session import Event, Session
from .settings import Plan, Setup, amended
from .station import BeltCheck, BendCheck, Reading, ZeroReading
from .track import FOLDER, PLACES, TRACK, Track, read_track, typed_track

# All kinds by their names, in the order in which a session takes them.
KINDS: dict[str, type[Observation]] = {
    reading.kind: reading
    for reading in (Reading, BendCheck, ZeroReading, BeltCheck, GaitRun, FilmReading, Push)
}

READING_COLUMNS = (
    "reading",
    "kind",
    "time_utc",
    "setup",
    "replaces",
    "lambda_deg",
    "incline_deg",
    "belt_speed_m_s",
    "drift_m_s",
    "reversed_deg",
    "between_links_deg",
    "alpha_deg",
    "beta_deg",
    "omega_rad_s",
    "distance_m",
    "duration_s",
    "speed_m_s",
    "speed_sigma_m_s",
    "more",
    "comment",
)
TRACK_WORDS = ("track", "track_sha256")  # words of a kind with a track, in the column `more`
DOUBTFUL = "doubtful"  # word of a reading that is void from its first line on
LINKS = "links"  # links, as session.toml said when the reading was taken
Row = Mapping[str, str]
TORN = "#torn"
EVENT_COLUMNS = ("time_utc", "event", "reading", "detail")
ON_READINGS = ("void", "restore", "undo")
Numbered = dict[int, Row]  # rows by the numbers of their readings


def kind_of(name: str) -> type[Observation]:
    """Return a kind of reading by its name; raises BadInput."""
    if name not in KINDS:
        raise BadInput(f"kind is {name!r}; it must be one of {', '.join(KINDS)}")
    return KINDS[name]


def reading_row(name: str, cells: Cells, plan: Plan | None = None) -> dict[str, str]:
    """Return a row of all columns; raises BadInput for a kind or a column that is not known.

    plan: the session's, which tells how the robot is bent where the cells do not.
    """
    kind = kind_of(name)
    fields = {field.column: field for field in kind.declared.values()}
    planned = {"bend": plan.bend} if plan is not None and "bend" in fields else {}
    row, more = dict.fromkeys(READING_COLUMNS, "") | {"kind": kind.kind}, []
    for column, value in (planned | dict(cells)).items():
        if column not in (*fields, LINKS, DOUBTFUL):
            columns = ", ".join([*fields, *([PLACES] if kind.columns == TRACK else [])])
            raise BadInput(f"unknown column {column!r}; a reading of kind {name} has {columns}")
        text = value if isinstance(value, str) else f"{value:.10g}"
        field = fields.get(column)
        if field is not None and not field.is_number:
            text = field.read(text)
        if column in row:
            row[column] = text
        elif text:
            more.append(f"{column}={text}")
    return row | {"more": " ".join(more)}


def words_of(row: Row) -> dict[str, str]:
    """Return what the column `more` says, name -> text."""
    return {name: text for name, _, text in (w.partition("=") for w in row["more"].split())}


def content(row: Row) -> frozenset[tuple[str, str]]:
    """Return what a row says of its reading, without when and where it was kept."""
    omitted = {"reading", "time_utc", "setup", "replaces", "comment", "more", "where", "track"}
    omitted |= {LINKS, "listed"}  # the second of older programs
    cells = {**row, **words_of(row)}
    if places := cells.pop(PLACES, ""):  # older programs kept a typed track in its row
        cells[TRACK_WORDS[1]] = Track.from_samples(TRACK, typed_track(places)).sha256
    return frozenset(cell for cell in cells.items() if cell[1] and cell[0] not in omitted)


def make_reading(row: Row, common: Mapping[str, Any]) -> Any:
    """Return the reading that a row of a known kind holds, of its kind's class; raises BadInput.

    common: number, and where known voided, comment and track.
    """
    kind, cells = kind_of(row["kind"]), words_of(row) | {c: text for c, text in row.items() if text}
    values = {
        name: field.read(cells.get(field.column, "")) for name, field in kind.declared.items()
    }
    return kind(**values, **common)


def load_session(folder: str | Path) -> Session:
    """Read a session's folder.

    Parameters
    ----------
    folder
        Holds session.toml and readings.csv.

    Returns
    -------
    Session
        The set-up and all readings.

    Raises
    ------
    BadInput
        If anything is missing, unknown, in other units, out of range or of a newer format, or if no
        reading is left to use. The message names file, line, value and limits.

    Examples
    --------
    >>> session = sn.load_session("calibration_data/nirakh-2005")
    >>> len(session.kept_stations)
    11
    """
    session = read_session(folder)
    if not (session.kept_stations or session.on_floor or session.kept_crawls):
        raise BadInput(
            f"{session.where}: no reading to use among {len(session.readings)}; take some"
        )
    return session


def read_session(folder: str | Path) -> Session:
    """Read a session's folder as load_session does, one that has no readings yet, too."""
    folder, notes = Path(folder), list[str]()
    top, path = Table.load(check_session(folder)), folder / "readings.csv"
    top.check_format(
        2,
        "which held stations alone, and is not read; calibration_data/README.md says what format "
        "2 has",
    )
    events = read_events(folder, notes)
    details = [event.detail for event in events if event.event == "amend"]
    setup = Setup.read(amended(top, details, folder / "events.csv"))
    if details:
        notes.append(
            f"{folder / 'events.csv'}: what older programs amended holds over session.toml"
        )
    rows = numbered_rows(path, notes)
    voided = _voided(rows, events, folder / "events.csv")
    session = Session(setup, (), str(path), folder=folder, events=tuple(events))
    left_out = list[str]()
    for number, row in sorted(rows.items()):
        kind = KINDS.get(row["kind"])
        if kind is None or words_of(row).get("by") == "marks":
            left_out.append(row["kind"] if kind is None else f"{row['kind']} by marks")
            continue
        common = {
            "number": number,
            "voided": number in voided,
            "comment": "; ".join(filter(None, (voided.get(number), row["comment"]))),
        }
        with located(row["where"]):
            facing = words_of(row).get("facing", "")
            if number not in voided and facing in ("up", "back"):
                raise BadInput(
                    f"reading {number} has facing={facing}: its wheels rolled backwards, and a fit "
                    "knows one friction along the wheels. If they roll alike both ways, take that "
                    "word out of its line; else void the reading"
                )
            session = session.with_reading(make_reading(row, common | _track(row, kind, folder)))
    links = str(setup.robot.links)
    counts = {n: words_of(row).get(LINKS, links) for n, row in rows.items() if n not in voided}
    changed = [str(number) for number, count in counts.items() if count != links]
    if changed:
        notes.append(
            f"readings {', '.join(changed)} were taken when session.toml said "
            f"{' or '.join(sorted({*counts.values()} - {links}))} links; a fit takes {links} for "
            "all. If it is another robot, it needs a session of its own"
        )
    if left_out:
        kinds = ", ".join(sorted(set(left_out)))
        notes.append(
            f"{count_text(len(left_out), 'reading')} of kinds not used here ({kinds}) left out"
        )
    return replace(session, notes=tuple(notes))


def check_session(folder: Path) -> Path:
    """Return the path of a session's settings; raises BadInput where there is no session."""
    path = folder / "session.toml"
    if not path.exists():
        raise BadInput(
            f"{folder}: no session here (no session.toml); `serpenoid calibrate new {folder}` "
            "begins one"
        )
    return path


def read_events(folder: Path, notes: list[str]) -> list[Event]:
    """Return a session's events in the order they were written; raises BadInput."""
    kinds = (
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
    events = []
    for row in rows_in(folder / "events.csv", EVENT_COLUMNS, notes):
        with located(row["where"]):
            event = check_choice("event", row["event"], kinds)
            number = whole_number("reading", row["reading"]) if row["reading"] else 0
            events.append(Event(event, number, row["detail"]))
    return events


def rows_in(path: Path, columns: tuple[str, ...], notes: list[str]) -> Iterator[Row]:
    """Yield the lines below the header by their columns, `where` each stands too; raises BadInput.

    notes: takes what is told of lines that do not count.
    """
    backup = f"take it from a backup; if there is none, its first line is {','.join(columns)}"
    text = read_text(path) if path.exists() else ""
    if not text.strip():
        raise BadInput(f"{path}: missing or empty, but it belongs to the session; {backup}")
    lines = text.split("\n")
    if lines[-1].strip():
        notes.append(
            f"{path}:{len(lines)}: the last line has no end: it was cut short while it was "
            "written, and does not count"
        )
    with located(f"{path}:1"):
        header = _cells(lines[0]) if len(lines) > 1 else []
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


def numbered_rows(path: Path, notes: list[str]) -> Numbered:
    """Return the rows of all readings by number, each checked against those before it.

    notes: takes what is told of lines that do not count. Raises BadInput.
    """
    rows: Numbered = {}
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
        kind = "push" if row["kind"] == "coast" else row["kind"]  # its name in older files
        rows[number] = {**row, "kind": kind}
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
        if event.event == "restore":
            why.pop(event.reading, None)
            continue
        why[event.reading] = event.detail or "undone"
        if event.event == "undo":
            why.pop(int(rows[event.reading]["replaces"] or 0), None)
    return why


def _track(row: Row, kind: type[Observation], folder: Path) -> dict[str, Track]:
    """Return the track of a reading whose kind has one."""
    words = words_of(row)
    if PLACES in words:  # older files have a typed track in its row
        return {"track": Track.from_samples(kind.columns, typed_track(words[PLACES]))}
    name, sha256 = (words.get(word, "") for word in TRACK_WORDS)
    if not kind.columns or (not name and kind.track_may_miss):
        return {}
    if not re.fullmatch(rf"{FOLDER}/\w+\.csv", name):
        raise BadInput(f"track is {name!r}; it must be a file such as {FOLDER}/0001.csv")
    return {"track": read_track(folder / name, kind.columns, sha256)}


def whole_number(name: str, text: str) -> int:
    """Return a cell's whole number from 1, or raise BadInput."""
    if not re.fullmatch("[1-9][0-9]{0,8}", text):
        raise BadInput(f"{name} is {text!r}; it must be a whole number from 1")
    return int(text)
