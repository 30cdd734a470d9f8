"""Readings that were written down by hand and typed into a spreadsheet, taken in at once.

The file's columns are those of readings.csv that a kind needs, `incline_percent` and
`belt_speed_km_h` allowed. Semicolons with decimal commas are a spreadsheet's habit, and read.
"""

from __future__ import annotations

import csv
import hashlib
from pathlib import Path

from ...model.errors import BadInput
from ...model.toml_table import located, read_text
from .journal import Journal
from .person.typed_cells import FIELDS, read_cells

_OTHER_UNITS = {
    "incline_percent": ("incline_deg", "%"),
    "belt_speed_km_h": ("belt_speed_m_s", "km/h"),
    "drift_km_h": ("drift_m_s", "km/h"),
}
HEADINGS = "kind, lambda_deg, incline_deg, belt_speed_m_s, drift_m_s, comment"


def add_sheet(journal: Journal, path: Path) -> tuple[int, list[str]]:
    """Add every row of a CSV file to a session; return how many, and what to tell.

    Nothing is added unless every row can be; the same file is not taken twice. Raises BadInput.
    """
    text = read_text(path)
    digest = hashlib.sha256(text.encode()).hexdigest()[:16]
    if any(e.event == "note" and digest in e.detail for e in journal.events):
        raise BadInput(f"{path}: this very file was taken in before; nothing is added twice")
    semicolons = ";" in text.split("\n", 1)[0]
    rows = list(csv.reader(text.splitlines(), delimiter=";" if semicolons else ","))
    if not rows or "kind" not in _names(rows[0]):
        raise BadInput(f"{path}:1: the first line must name the columns, such as {HEADINGS}")
    header = _names(rows[0])
    made = []
    for number, cells in enumerate(rows[1:], 2):
        if any(cell.strip() for cell in cells):
            with located(f"{path}:{number}"):
                made.append(_reading(header, cells, journal))
    for kind, values, comment in made:
        journal.add(kind, values, comment=comment)
    journal.event("note", detail=f"sheet {path.name}, {digest}")
    told = ["cells parted by semicolons, decimals by commas: read as such"] if semicolons else []
    return len(made), told


def _names(cells: list[str]) -> list[str]:
    return [cell.strip() for cell in cells]


def _reading(
    header: list[str], cells: list[str], journal: Journal
) -> tuple[str, dict[str, float], str]:
    """Return kind, values and comment of a row, checked as a journal checks them."""
    if len(cells) != len(header):
        raise BadInput(
            f"{len(cells)} cells where the header has {len(header)}; decimals with a comma need "
            "cells parted by semicolons"
        )
    row = dict(zip(header, _names(cells), strict=True))
    kind, comment = row.pop("kind"), row.pop("comment", "")
    if kind not in FIELDS:
        raise BadInput(f"kind is {kind!r}; it must be one of {', '.join(FIELDS)}")
    pairs = []
    for name, value in row.items():
        column, unit = _OTHER_UNITS.get(name, (name, ""))
        if value:
            pairs.append(f"{column}={value} {unit}".rstrip())
    values = read_cells(kind, pairs, journal.session.setup)
    journal.check(kind, values)
    return kind, values, comment
