"""Readings that were written down by hand and typed into a spreadsheet, taken in at once.

The file's columns are those of readings.csv that a kind needs, other units allowed (OTHER_UNITS).
Semicolons with decimal commas are a spreadsheet's habit, and read. A station or push that names no
bend has that of the protractor check above it; a line in which nothing was read is left out.
"""

from __future__ import annotations

import math
from pathlib import Path

from ...model.errors import BadInput
from ...model.files import csv_rows, read_text
from ...model.toml_table import located
from ..kinds.coast import WAYS
from ..kinds.declaration import DERIVED, PLANNED, Field
from ..kinds.rows import KINDS
from ..session import Procedure, Session
from .expected import series_of, series_of_pushes
from .journal import Journal, Listed, csv_line
from .parse_number import OTHER_UNITS, read_cells

NOT_READ = {f.column for kind in KINDS.values() for f in kind.fields if f.source == PLANNED} | {
    "kind",
    "comment",
}
NOT_TYPED = {"bend", "offset_deg", "waited_s", "time_sigma_s"}
LINES, SLIDES = 6, 4  # to fill in, of stations a bend and of slides
BENT = ("station", "coast")  # kinds that are bent as the check above them shows
ON_FLOOR = ("bend", "coast", "slide", "gait")  # kinds of the sheet of a floor
HEADINGS = "kind, lambda_deg, incline_deg, belt_speed_m_s, drift_m_s, comment"


def add_sheet(journal: Journal, path: Path) -> tuple[int, list[str]]:
    """Add every row of a CSV file to a session; return how many, and what to tell.

    Nothing is added unless every row can be, and no row twice. Raises BadInput.
    """
    text = read_text(path)
    semicolons = ";" in text.split("\n", 1)[0]
    rows = csv_rows(text, path, ";" if semicolons else ",")
    header, *lines = [[cell.strip() for cell in row] for row in rows] or [[]]
    if "kind" not in header:
        raise BadInput(f"{path}:1: the first line must name the columns, such as {HEADINGS}")
    listed: list[Listed] = []
    lambda_deg = ""
    for number, cells in enumerate(lines, 2):
        with located(f"{path}:{number}"):
            row = _row(header, cells) if any(cells) else {}
            kind, comment = row.pop("kind", ""), row.pop("comment", "")
            if not any(OTHER_UNITS.get(name, (name,))[0] not in NOT_READ for name in row):
                continue
            if kind in BENT and lambda_deg and "lambda_deg" not in row:
                row["lambda_deg"] = lambda_deg
            pairs = (f"{name}={value}" for name, value in row.items())
            values = read_cells(kind, pairs, journal.session.setup)
            journal.check(kind, values)
            listed.append((kind, values, comment))
            if kind == "bend":
                lambda_deg = f"{(180 - float(values['between_links_deg'])) / 2:.6g}"
    if not listed:
        raise BadInput(
            f"{path}: no line has a reading in it; type them in, then add the file again"
        )
    added = journal.add_once(listed)
    if not added:
        raise BadInput(f"{path}: all its readings were taken in before; nothing is added twice")
    journal.event("note", detail=f"sheet {path.name}")
    notes = ["cells parted by semicolons, decimals by commas: read as such"] if semicolons else []
    if added < len(listed):
        notes.append(f"{len(listed) - added} reading(s) of it were there already")
    return added, notes


def _row(header: list[str], cells: list[str]) -> dict[str, str]:
    """Return what a line's cells say, by their columns."""
    if len(cells) != len(header):
        raise BadInput(
            f"{len(cells)} cells where the header has {len(header)}; decimals with a comma need "
            "cells parted by semicolons"
        )
    return {name: cell for name, cell in zip(header, cells, strict=True) if cell}


def sheet_text(session: Session) -> str:
    """Return a CSV to type the printed sheet into: its lines, with what the plan says filled in."""
    plan = session.setup.procedure
    columns = _headings(plan)
    rows = [dict(zip(columns, columns, strict=True)), *_planned_rows(plan)]
    for gait in plan.gaits:
        angles = {"alpha_deg": gait.alpha_rad, "beta_deg": gait.beta_rad}
        cells = {name: f"{math.degrees(angle):.6g}" for name, angle in angles.items()}
        cells["frequency_hz"] = f"{gait.omega_rad_s / (2 * math.pi):.6g}"
        rows += [{"kind": "gait", **cells}] * plan.gait_runs
    return "".join(csv_line([row.get(name, "") for name in columns]) for row in rows)


def _planned_rows(plan: Procedure) -> list[dict[str, str]]:
    """Return the lines of stations and zeros, or of pushes and slides, with what is planned."""
    if plan.on == "floor":
        series = series_of_pushes(plan)
        first: list[dict[str, str]] = []
        lines = [{"kind": "coast", "way": way} for way in ways_of(plan)]
        last = [{"kind": "slide", "lambda_deg": "0"}] * SLIDES
    else:
        series = series_of(plan)
        first = last = [{"kind": "zero"}]
        lines = [{"kind": "station"}] * LINES
    rows = [*first]
    for pose in series:
        bent, facing = bool(pose.lambda_rad), pose.facing.removeprefix("ahead")
        if bent:
            rows.append({"kind": "bend", "lambda_deg": f"{math.degrees(pose.lambda_rad):.6g}"})
        rows += [line | {"lambda_deg": "" if bent else "0", "facing": facing} for line in lines]
    return rows + last


def ways_of(plan: Procedure) -> list[str]:
    """Return the ways of the pushes that are planned in each bend, in turn."""
    return [WAYS[k % len(WAYS)] for k in range(plan.pushes)]


def _headings(plan: Procedure) -> list[str]:
    """Return the columns that a person types, kind by kind, those that the plan fills in first."""
    names = ON_FLOOR if plan.on == "floor" else tuple(KINDS)
    kinds = [sorted(KINDS[name].fields, key=lambda f: f.source != PLANNED) for name in names]
    fields = [f for kind in kinds for f in kind if f.source != DERIVED]
    columns = [f.sheet[0] if isinstance(f, Field) and f.sheet else f.column for f in fields]
    left_out = NOT_TYPED if plan.ratchet else {*NOT_TYPED, "facing"}
    return ["kind", *(name for name in dict.fromkeys(columns) if name not in left_out), "comment"]
