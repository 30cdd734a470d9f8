"""Readings as rows of readings.csv, and back, by the declaration of their kinds.

A field without a column of its own stands in the column `more` as NAME=VALUE, so that files of
every age have the same header and older programs still read them.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ..base.errors import BadInput
from .checks import BeltCheck, BendCheck, ZeroReading
from .declaration import Cells, Taken, Word
from .film import FilmReading
from .gait_run import GaitRun
from .push import Push
from .station import Reading

# All kinds by their names, in the order in which a session takes them.
KINDS: dict[str, type[Taken]] = {
    reading.kind: reading
    for reading in (
        Reading,
        BendCheck,
        ZeroReading,
        BeltCheck,
        GaitRun,
        FilmReading,
        Push,
    )
}

OLD_KINDS = {"coast": "push"}  # names of kinds in older files -> their names

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
TRACK_WORDS = ("track", "track_sha256")  # of a kind with a track, in the column `more`
DOUBTFUL = "doubtful"  # of a reading that is void from its first line on
LISTED = "listed"  # of a reading that came from a list: a hash of the list up to it
Row = Mapping[str, str]


def kind_of(name: str) -> type[Taken]:
    """Return a kind of reading by its name; raises BadInput."""
    name = OLD_KINDS.get(name, name)
    if name not in KINDS:
        raise BadInput(f"kind is {name!r}; it must be one of {', '.join(KINDS)}")
    return KINDS[name]


def reading_row(name: str, cells: Cells, plan: object = None) -> dict[str, str]:
    """Return a row of all columns; raises BadInput for a kind or a column that is not known.

    plan: the session's, which tells the words that it has and the cells have not.
    """
    kind = kind_of(name)
    words = {w.column: w for w in kind.fields if isinstance(w, Word)}
    if plan is not None:
        cells = {c: getattr(plan, c) for c, w in words.items() if w.of_plan} | dict(cells)
    known = [f.column for f in kind.fields]
    row, more = dict.fromkeys(READING_COLUMNS, "") | {"kind": kind.kind}, []
    for column, value in cells.items():
        text = value if isinstance(value, str) else f"{value:.10g}"
        if column in row:
            row[column] = text
        elif column not in (LISTED, DOUBTFUL, *known, *(TRACK_WORDS if kind.columns else ())):
            known_words = ", ".join(known)
            raise BadInput(f"unknown column {column!r}; a reading of kind {name} has {known_words}")
        elif text and column in words:
            word = words[column]
            text = word.tidy(text) if word.tidy else text
            more += [f"{column}={text}"] * (text != word.usual)
        elif text:
            more.append(f"{column}={text}")
    return row | {"more": " ".join(more)}


def words_of(row: Row) -> dict[str, str]:
    """Return what the column `more` says, name -> text."""
    return {name: text for name, _, text in (w.partition("=") for w in row["more"].split())}


def make_reading(row: Row, common: Mapping[str, Any]) -> Any:
    """Return the reading that a row of a known kind holds, of its kind's class; raises BadInput.

    common: number, and where known voided, comment, time_utc and track.
    """
    kind, said = kind_of(row["kind"]), words_of(row)
    cells = {f.column: row.get(f.column, "") or said.get(f.column, "") for f in kind.fields}
    values = {kind.attributes[f.column]: f.read(cells[f.column]) for f in kind.fields}
    return kind(**values, **common)
