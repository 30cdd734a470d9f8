"""Files of measured rows: dataclasses of numbers and texts, one a line of a CSV file."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

from ..model.files import csv_rows, read_text, write_csv

T = TypeVar("T")
_NOTHING: Mapping[str, str] = {}


def write_rows(path: Path, rows: Sequence[Any], also: Mapping[str, str] = _NOTHING) -> None:
    """Write dataclasses of one kind, with the texts of `also` in each line."""
    header = [f.name for f in dataclasses.fields(rows[0])]
    lines = [[*dataclasses.astuple(row), *also.values()] for row in rows]
    write_csv(path, [*header, *also], lines)


def read_rows(path: Path, kind: type[T]) -> list[T]:
    """Return the rows of a file that write_rows wrote; an empty number is None."""
    header, *lines = csv_rows(read_text(path))
    texts = {f.name: f.type == "str" for f in dataclasses.fields(kind)}  # type: ignore[arg-type]

    def value(name: str, cell: str) -> Any:
        return cell if texts[name] else float(cell) if cell else None

    cells = [dict(zip(header, line, strict=True)) for line in lines]
    return [kind(**{name: value(name, cell[name]) for name in texts}) for cell in cells]
