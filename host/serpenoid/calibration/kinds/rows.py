"""Readings as rows of readings.csv, and back, by the declaration of their kinds.

A field without a column of its own stands in the column `more` as NAME=VALUE, so that files of
every age have the same header and older programs still read them.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ...model.errors import BadInput
from .declaration import Cells, Kind, Word
from .table import KINDS

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
DOUBTFUL = "doubtful"  # of a reading that is void from its first line on, until it is restored
LISTED = "listed"  # of a reading that came from a list: a hash of the list up to it
Row = Mapping[str, str]


def kind_of(name: str) -> Kind:
    """Return a kind of reading by its name; raises BadInput."""
    if name not in KINDS:
        raise BadInput(f"kind is {name!r}; it must be one of {', '.join(KINDS)}")
    return KINDS[name]


def reading_row(name: str, cells: Cells, plan: object = None) -> dict[str, str]:
    """Return a row of all columns; raises BadInput for a kind or a column that is not known.

    plan: the session's, which tells the words that it has and the cells have not.
    """
    kind = kind_of(name)
    if plan is not None:
        planned = {w.column: getattr(plan, w.column) for w in kind.words if w.of_plan}
        cells = planned | dict(cells)
    usual = {w.column: w.usual for w in kind.words}
    own = {LISTED, DOUBTFUL, *(f.column for f in kind.fields), *(TRACK_WORDS if kind.track else ())}
    unknown = next((c for c in cells if c not in own and c not in READING_COLUMNS), None)
    if unknown is not None:
        known = ", ".join(f.column for f in kind.fields)
        raise BadInput(f"unknown column {unknown!r}; a reading of kind {name} has {known}")
    tidy = {w.column: w.tidy for w in kind.words if w.tidy}
    texts = {c: v if isinstance(v, str) else f"{v:.10g}" for c, v in cells.items()}
    texts |= {c: tidy[c](text) for c, text in texts.items() if c in tidy and text}
    more = [
        f"{c}={text}"
        for c, text in texts.items()
        if c not in READING_COLUMNS and text and text != usual.get(c)
    ]
    there = {c: text for c, text in texts.items() if c in READING_COLUMNS}
    return dict.fromkeys(READING_COLUMNS, "") | {"kind": name, "more": " ".join(more)} | there


def words_of(row: Row) -> dict[str, str]:
    """Return what the column `more` says, name -> text."""
    return {name: text for name, _, text in (w.partition("=") for w in row["more"].split())}


def cells_of(row: Row) -> dict[str, str]:
    """Return the fields of a row that hold something, column -> text; words always."""
    said = words_of(row)
    found = {}
    for field in kind_of(row["kind"]).fields:
        text = row.get(field.column, "") or said.get(field.column, "")
        if isinstance(field, Word):
            found[field.column] = text or field.usual
        elif text:
            found[field.column] = text
    return found


def make_reading(row: Row, common: Mapping[str, Any]) -> Any:
    """Return the reading that a row of a known kind holds, of its kind's class; raises BadInput.

    common: number, and where known voided, comment, time_utc and track.
    """
    kind, cells = kind_of(row["kind"]), cells_of(row)
    values = {f.name: f.read(cells.get(f.column, "")) for f in kind.fields}
    return kind.reading(**values, **common)
