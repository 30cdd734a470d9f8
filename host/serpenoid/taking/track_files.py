"""Tracks made by other programs: Tracker's, Kinovea's and plain tables of time and place.

Columns are told by their names, as Tracker, Kinovea (in its languages) and people give them: `t`,
`Time (ms)`, `Trajectory 1/X (cm)`, `x_m`. A unit of no time or length is refused, never dropped.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..base.checks import check_choice, count_text
from ..base.errors import BadInput
from ..base.tables import TextTable, read_table
from ..base.toml_table import located
from ..session.declaration import LENGTH_UNITS, Units
from ..session.track import Floats
from .parse_number import spelled_unit

TIME_UNITS: Units = {
    "s": 1.0,
    "ms": 1e-3,
    "μs": 1e-6,
    "min": 60.0,
    "min/100": 0.6,
    "hour/10000": 0.36,
}
# What a column is -> words in its name; those of a time in Kinovea's languages.
WORDS = {
    "t": "t time timestamp temps zeit tiempo tempo tid tijd czas čas vreme vrijeme време время "
    "час χρόνος aika zaman waktu masa timp laikas idő 時間 时间 시간 เวลา زمان الزمن thời",
    "frame": "n frame frames step image picture bild",
    "rate": "v vel velocity speed acc accel acceleration",
}
TIME_ADVICE = (
    "export the time in s or ms (Tracker: take t as the first column; Kinovea: milliseconds as "
    "the time format in its preferences, and no normalized time), or, if it is in s, name the "
    "column Time (s)"
)


class Column(NamedTuple):
    """Hold where a column is, its name as written, what it is ("t", "frame", "x", "y" or "").

    unit: as written, None where none is.
    """

    place: int
    name: str
    meaning: str
    unit: str | None

    def factor(self, units: Units, advice: str) -> float | None:
        """Return what its numbers are multiplied with, None if it names no unit; raises BadInput.

        units: that it may be in. advice: what to do about another.
        """
        if self.unit is None:
            return None
        unit = spelled_unit(self.unit, units)
        if not unit:
            raise BadInput(f"{self.name} is in {self.unit or 'an empty unit'!r}, {advice}")
        return units[unit]


def _column(place: int, cell: str) -> Column:
    """Return what the name of a column says."""
    match = re.search(r"[(\[{]\s*([^()\[\]{}]*?)\s*[)\]}]\s*$", cell)
    if match is None:
        match = re.search(r"[\s_/]+(?:in\s+)?([^\s_/]+(?:/\d+)?)$", cell)
        match = match if match and spelled_unit(match[1], TIME_UNITS | LENGTH_UNITS) else None
    name = (cell[: match.start()] if match else cell).casefold()
    words = re.findall(r"[^\s/_.,:;#|()-]+", name) or [""]
    axis = re.compile(r"(?:pos|position|coord)?([xy])(?:pos|position|coord)?\d*").fullmatch
    match_axis = axis(words[-1]) or axis(words[0])

    def says(meaning: str, *parts: str) -> bool:
        return not {*parts}.isdisjoint(WORDS[meaning].casefold().split())

    meaning = ""
    if says("t", words[0], words[-1]):
        meaning = "t"
    elif len(words) == 1 and says("frame", *words):
        meaning = "frame"
    elif match_axis and not (says("rate", *words) or re.match("[vapl]_", name)):
        meaning = match_axis[1]  # v_x and a_x are Tracker's rates
    return Column(place, cell, meaning, match[1] if match else None)


def _columns(head: list[str]) -> list[Column] | None:
    """Return time, x and, if it is there, y of the first point; None without time and x."""
    first = dict[str, Column]()
    for place, cell in enumerate(head):
        column = _column(place, cell)
        first.setdefault(column.meaning, column)
    time, x, y = first.get("t") or first.get("frame"), first.get("x"), first.get("y")
    return [column for column in (time, x, y) if column] if time and x else None


def read_track_file(path: Path, unit: str | None = None) -> tuple[Floats, list[str]]:
    """Return t_s, x_m, y_m of a file's first point, a row each, and what is to be told of it.

    A time without unit is in s. Rows with an empty place are left out.

    Parameters
    ----------
    path
        The file.
    unit
        Of lengths whose column names none: one of LENGTH_UNITS.

    Raises
    ------
    BadInput
        A unit is missing or is none of time or length, or a cell is no number; the message names
        the line, and what to change.
    """
    if unit is not None:
        check_choice("unit", unit, tuple(LENGTH_UNITS))
    needed = "t_s,x_m,y_m, or as in Time (ms);Trajectory 1/X (cm);Trajectory 1/Y (cm)"
    length_advice = (
        "which is no length; set the scale and export again (Tracker: Track > New > Calibration "
        "Tools; Kinovea: draw a line of known length, right-click it, Calibrate); units that are "
        f"read: {', '.join(LENGTH_UNITS)}"
    )
    table, columns = read_table(path, _columns, needed)
    time, *places = columns
    rows = []
    for line, cells in table.rows:
        texts = [cells[column.place] for column in columns if column.place < len(cells)]
        if len(texts) == len(columns) and {"", "-", "--", "–", "?"}.isdisjoint(texts):
            numbers = [_number(table, line, *cell) for cell in zip(texts, columns, strict=True)]
            rows.append(numbers)
    track = np.zeros((len(rows), 3))
    with located(str(path)):
        if time.meaning == "frame":
            raise BadInput(f"{time.name} is no time in seconds but in frames; {TIME_ADVICE}")
        factors = [time.factor(TIME_UNITS, TIME_ADVICE) or 1.0]
        for column in places:
            factor = column.factor(LENGTH_UNITS, length_advice) or LENGTH_UNITS.get(unit or "")
            if factor is None:
                raise BadInput(
                    f"its lengths have no unit ({column.name}); say it, by --unit or behind the "
                    f"file's name at the prompt: one of {', '.join(LENGTH_UNITS)}"
                )
            factors.append(factor)
        track[:, : len(columns)] = np.reshape(rows, (-1, len(columns))) * factors
        _check_times(track[:, 0], time)
    notes = []
    if sum(_column(0, cell).meaning == "x" for cell in table.head) > 1:
        first = places[0].name
        notes.append(f"{path.name}: the first point, {first}, is taken; the others are left out")
    if len(places) == 1:
        notes.append(f"{path.name}: no column y; the track is taken as straight along x")
    return track[np.diff(track[:, 0], prepend=-np.inf) != 0.0], notes


def _number(table: TextTable, line: int, text: str, column: Column) -> float:
    try:
        return table.number(text)
    except ValueError:
        clock = f"; {TIME_ADVICE}" if ":" in text else ""
        raise BadInput(
            f"{table.where(line)}: {column.name} is {text!r}, not a number{clock}"
        ) from None


def _check_times(t: Floats, column: Column) -> None:
    """Raise BadInput where times cannot be seconds, or what their unit says."""
    min_places = 3
    if len(t) < min_places:
        raise BadInput(f"{count_text(len(t), 'place')} in it; is it a track of time, x and y?")
    steps = np.diff(t)
    if not (steps > 0.0).any() or (steps < 0.0).any():
        raise BadInput(f"the times in {column.name} do not rise; {TIME_ADVICE}")
    rate_hz = 1 / float(np.median(steps[steps > 0.0]))
    # No camera of a phone takes more, no film of a push without unit has fewer pictures a second.
    max_hz, min_hz = 2000.0, 2.0
    if rate_hz > max_hz or (column.unit is None and rate_hz < min_hz):
        raise BadInput(
            f"{column.name} says {rate_hz:.2g} pictures a second: its unit is wrong; {TIME_ADVICE}"
        )
