"""Files of a benchmark: rows, one a line of a CSV file, and tables in Markdown pages."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

from ..base.errors import BadInput
from ..base.files import csv_rows, read_text, write_csv, write_text

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


def renew_table(path: Path, name: str, table: str) -> None:
    """Put a table between the markers `<!-- NAME: begin -->` and `<!-- NAME: end -->` of a page.

    Raises BadInput where a marker is missing or stands twice; the page is then left as it is.
    """
    begin, end = f"<!-- {name}: begin -->", f"<!-- {name}: end -->"
    text = read_text(path)
    if text.count(begin) != 1 or text.count(end) != 1:
        raise BadInput(f"{path} must have {begin!r} and {end!r} once each, around the table")
    head, rest = text.split(begin)
    write_text(path, f"{head}{begin}\n{table}\n{end}{rest.split(end)[1]}")
