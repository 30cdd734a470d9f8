"""What the accuracy benchmark writes: CSV and JSON."""

from __future__ import annotations

import csv
import json
from collections.abc import Sequence
from dataclasses import fields
from pathlib import Path

from .. import machine
from ..problems import problems
from ..reference import reference
from .contenders import absent
from .equal_error import headline
from .measure import Row, as_dicts


def write_csv(rows: Sequence[Row], path: Path) -> None:
    """Write all rows, with processor and compiler in every one."""
    here = {"cpu": machine.cpu(), "compiler": machine.compiler()}
    with path.open("w", newline="") as file:
        writer: csv.DictWriter[str] = csv.DictWriter(file, [*(f.name for f in fields(Row)), *here])
        writer.writeheader()
        writer.writerows({**row, **here} for row in as_dicts(list(rows)))


def read_csv(path: Path) -> list[Row]:
    """Return the rows of a file that write_csv wrote."""

    def row(line: dict[str, str]) -> Row:
        def number(name: str) -> float | None:
            return float(line[name]) if line[name] else None

        return Row(
            line["scene"],
            line["method"],
            line["family"],
            line["kind"],
            float(line["setting"]),
            number("error"),
            number("time_s"),
            number("spread"),
            int(line["rounds"]),
            float(line["simulated_s"]),
            line["note"],
        )

    with path.open(newline="") as file:
        return [row(line) for line in csv.DictReader(file)]


def write_json(rows: Sequence[Row], path: Path) -> None:
    """Write ratios at equal error, how well each reference is known, and the machine."""
    measured = {row.scene for row in rows}
    known = {p.name: reference(p).known_to for p in problems() if p.name in measured}
    content = {
        "cpu": machine.cpu(),
        "compiler": machine.compiler(),
        "versions": machine.versions(),
        "absent": absent(),
        "references_known_to": known,
        "headline": headline(rows),
    }
    path.write_text(json.dumps(content, indent=1) + "\n")
