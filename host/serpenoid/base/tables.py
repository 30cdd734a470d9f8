"""Read tables of numbers that other programs have exported as text.

Cells are separated by tabs, semicolons, commas or spaces, as the names of the columns are. Decimals
have a point or a comma. Encodings are UTF-8, UTF-16 with a byte-order mark, and else Windows-1252,
in which numbers are the same. Lines above the names of the columns, such as a title or the line
`sep=;` of spreadsheets, are skipped.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from .errors import BadInput
from .files import csv_rows, read_bytes, with_line_feeds

# Suffixes of other programs' files, which contain tables but are not text.
OTHER_PROGRAMS = (".trk", ".trz", ".kva", ".xlsx", ".xls", ".ods", ".numbers", ".json")
Columns = TypeVar("Columns")


@dataclass(frozen=True)
class TextTable:
    """The cells of a table, stripped and without quotes.

    path, text: the file and its text. head: names of the columns. rows: line number and cells of
    each line below; a blank line has no cells.
    """

    path: Path
    text: str
    head: list[str]
    rows: list[tuple[int, list[str]]]

    def number(self, cell: str) -> float:
        """Return the number of a cell; raises ValueError."""
        text = cell.replace("−", "-").replace(",", ".")
        if not re.fullmatch(r"[+-]?(\d+(\.\d*)?|\.\d+)([eE][+-]?\d+)?", text):
            raise ValueError(f"{cell!r} is not a number")
        return float(text)

    def where(self, line: int) -> str:
        """Return file and line for messages."""
        return f"{self.path}:{line}"


def read_table(
    path: Path, find: Callable[[list[str]], Columns | None], needed: str
) -> tuple[TextTable, Columns]:
    """Return a file's table, and the columns found in it.

    Parameters
    ----------
    path
        The text file.
    find
        Function of the cells of a line. It returns the wanted columns, None if the line does not
        name them.
    needed
        Names of the needed columns, for the message.

    Raises
    ------
    BadInput
        If it is not a text file, or no line names the columns.
    """
    text = _decoded(path)
    lines = text.split("\n")
    for number, line in enumerate(lines[:20]):
        for separator in "\t;, ":  # Commas come late: decimals and names have them too.
            cells = _cells(line, separator)
            columns = find(cells) if cells else None
            if columns is not None:
                return _table(path, text, lines, number, separator), columns
    first = next((line.strip() for line in lines if line.strip()), "")
    says = f"its first line is {first[:120]!r}" if first else "the file is empty"
    raise BadInput(
        f"{path}: no line names the columns that are needed; {says}; make the names of the "
        f"columns {needed}"
    )


def number_columns(
    path: Path, needed: tuple[str, ...], optional: tuple[str, ...]
) -> dict[str, list[float]]:
    """Return the numbers of columns by their names; blank lines do not count.

    Raises BadInput if a needed column or a number is missing.
    """

    def find(head: list[str]) -> dict[str, int] | None:
        cells = [cell.casefold() for cell in head]
        names = [name for name in (*needed, *optional) if name in cells]
        return {name: cells.index(name) for name in names} if {*needed} <= {*names} else None

    table, places = read_table(path, find, ",".join(needed))
    columns = {name: list[float]() for name in places}
    for line, cells in filter(lambda row: any(row[1]), table.rows):
        for name, place in places.items():
            try:
                value = table.number(cells[place])
            except (IndexError, ValueError):
                value = math.nan
            if not math.isfinite(value):
                raise BadInput(f"{table.where(line)}: {name} is no finite number")
            columns[name].append(value)
    return columns


def _decoded(path: Path) -> str:
    """Return the text of a file in UTF-8, UTF-16 with its mark, or Windows-1252."""
    data = read_bytes(path)
    begin = data.lstrip(b"\xef\xbb\xbf")
    # Starts of workbooks, and of XML, such as Tracker's projects.
    binary = b"PK\x03\x04", b"\xd0\xcf\x11\xe0", b"<?xml"
    if path.suffix.lower() in OTHER_PROGRAMS or begin.startswith(binary):
        raise BadInput(
            f"{path}: this is another program's own file; export the table there as text/CSV "
            "(Tracker: File > Export > Data File with t, x and y), and give that file"
        )
    try:
        if data.startswith((b"\xff\xfe", b"\xfe\xff")):
            return with_line_feeds(data.decode("utf-16"))
        if b"\0" in data:
            raise BadInput(f"{path}: zero bytes in it; if it is text in UTF-16, save it as UTF-8")
        return with_line_feeds(data.decode("utf-8-sig"))
    except UnicodeDecodeError:
        return with_line_feeds(data.decode("cp1252", errors="replace"))


def _cells(line: str, separator: str) -> list[str]:
    """Return the cells of one line, [] for a blank line."""
    if not line.strip():
        return []
    if separator == " ":
        return re.sub(r" +(?=[(\[])", "", line.replace('"', " ")).split()
    try:
        cells = csv_rows(line, delimiter=separator)[0]
    except BadInput:  # A single quotation mark is part of a cell.
        cells = line.split(separator)
    return [cell.strip().strip('"').strip() for cell in cells]


def _table(path: Path, text: str, lines: list[str], head: int, separator: str) -> TextTable:
    """Return the table below a line of names; raises BadInput for a row with too many cells."""
    names = _cells(lines[head], separator)
    rows = [(k, _cells(line, separator)) for k, line in enumerate(lines[head + 1 :], head + 2)]
    for number, cells in rows:
        surplus = any(cells[len(names) :]) and not cells[0].startswith("#")
        if surplus and separator != " ":
            raise BadInput(
                f"{path}:{number}: {len(cells)} cells where the names of the columns are "
                f"{len(names)}; decimals with a comma need cells parted by semicolons or tabs"
            )
    return TextTable(path, text, names, rows)
