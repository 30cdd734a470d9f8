"""Tracks made by other programs: Tracker's, Kinovea's and plain tables of time and place.

Columns are told by their names, as Tracker, Kinovea (in its languages) and people give them: `t`,
`Time (ms)`, `Trajectory 1/X (cm)`, `x_m`. A unit of no time or length is refused, never dropped.
"""

from __future__ import annotations

import hashlib
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..base.checks import check_choice
from ..base.errors import BadInput
from ..base.tables import EMPTY_CELLS, TextTable, read_table
from ..base.toml_table import located
from ..session.declaration import LENGTH_UNITS
from ..session.push import likely_units, unlikely_push
from .track_look import MOVES_M_S, speeds

Floats = NDArray[np.float64]
NEEDED = "t_s,x_m,y_m, or as in Time (ms);Trajectory 1/X (cm);Trajectory 1/Y (cm)"
TIME_UNITS = {"s": 1.0, "ms": 1e-3, "μs": 1e-6, "min": 60.0, "min/100": 0.6, "hour/10000": 0.36}
# What a column is -> words for it; those of a time in Kinovea's languages.
MEANINGS = {
    "t": "t time timestamp temps zeit tiempo tempo tid tijd czas čas vreme vrijeme време время "
    "час χρόνος aika zaman waktu masa timp laikas idő 時間 时间 시간 เวลา زمان الزمن thời",
    "frame": "n frame frames step image picture bild",
    "rate": "v vel velocity speed acc accel acceleration",
}
SPELLINGS = {
    "m": "meter meters metre metres м",
    "cm": "centimeter centimeters centimetre centimetres см",
    "mm": "millimeter millimeters millimetre millimetres мм",
    "in": 'inch inches "',
    "ft": "foot feet",
    "yd": "yard yards",
    "s": "sec secs second seconds с сек",
    "ms": "msec millisecond milliseconds мс 毫秒",
    "μs": "us microsecond microseconds",
    "min": "minute minutes",
}
_MEANING = {
    word.casefold(): meaning for meaning, words in MEANINGS.items() for word in words.split()
}
_UNIT = {word: unit for unit, words in SPELLINGS.items() for word in (unit, *words.split())}
_UNIT |= {unit: unit for unit in TIME_UNITS}
_IN_BRACKETS = re.compile(r"[(\[{]\s*([^()\[\]{}]*?)\s*[)\]}]\s*$")
_BEHIND = re.compile(r"[\s_/]+(?:in\s+)?([^\s_/]+(?:/\d+)?)$")
_AXIS = re.compile(r"(?:pos|position|coord)?([xy])(?:pos|position|coord)?\d*")
TIME_ADVICE = (
    "export the time in s or ms (Tracker: take t as the first column; Kinovea: milliseconds as "
    "the time format in its preferences, and no normalized time), or, if it is in s, name the "
    "column Time (s)"
)
LEAST_STEP_S = 1 / 2000  # between two pictures: no camera of a phone is faster
MOST_STEP_S = 0.5  # between two pictures of a push, where the time has no unit
FAST_S = 0.1  # a push is at its fastest for longer than this
FEWEST_PLACES = 3


@dataclass(frozen=True)
class TrackFile:
    """Hold t_s, x_m, y_m (rows, 3) of one point, the file's SHA-256, and what is to be told."""

    values: Floats
    sha256: str
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Column:
    """Hold where a column is, its name as written, what it is ("t", "frame", "x", "y" or "").

    unit: as written, None where none is.
    """

    place: int
    name: str
    meaning: str
    unit: str | None

    @classmethod
    def of(cls, place: int, cell: str) -> Column:
        """Return what the name of a column says."""
        found = _IN_BRACKETS.search(cell)
        if found is None:
            found = _BEHIND.search(cell)
            found = found if found and found[1].casefold() in _UNIT else None
        name = cell[: found.start()] if found else cell
        words = [word for word in re.split(r"[\s/_.,:;#|()-]+", name.casefold()) if word] or [""]
        meanings = [_MEANING.get(word, "") for word in words]
        axis = _AXIS.fullmatch(words[-1]) or _AXIS.fullmatch(words[0])
        rate = "rate" in meanings or re.match("[vapl]_", name.casefold())  # Tracker's v_x, a_x
        meaning = axis[1] if axis and not rate else ""
        if "t" in (meanings[0], meanings[-1]):
            meaning = "t"
        elif meanings == ["frame"]:
            meaning = "frame"
        return cls(place, cell, meaning, found[1] if found else None)

    @property
    def length_unit(self) -> str | None:
        """Return its unit, a key of LENGTH_UNITS; None if it names none. Raises BadInput."""
        unit = None if self.unit is None else _UNIT.get(self.unit.casefold(), "")
        if unit is None or unit in LENGTH_UNITS:
            return unit
        raise BadInput(
            f"{self.name} is in {self.unit or 'an empty unit'!r}, which is no length; set the "
            "scale and export again (Tracker: Track > New > Calibration Tools; Kinovea: "
            "draw a line of known length, right-click it, Calibrate); units that are read: "
            f"{', '.join(LENGTH_UNITS)}"
        )

    @property
    def time_s(self) -> float:
        """Return the duration of its unit, s; of s if it names none. Raises BadInput."""
        if self.unit is None and self.meaning == "t":
            return 1.0
        unit = _UNIT.get((self.unit or "frames").casefold(), "")
        if unit in TIME_UNITS:
            return TIME_UNITS[unit]
        raise BadInput(
            f"{self.name} is no time in seconds but in {self.unit or 'frames'}; {TIME_ADVICE}"
        )


def _columns(head: list[str]) -> list[Column] | None:
    """Return time, x and, if it is there, y of the first point; None without time and x."""
    columns = [Column.of(place, cell) for place, cell in enumerate(head)]
    by = {name: [c for c in columns if c.meaning == name] for name in ("t", "frame", "x", "y")}
    times = by["t"] or by["frame"]
    if not times or not by["x"]:
        return None
    return [times[0], by["x"][0], *by["y"][:1]]


def read_track_file(path: Path, unit: str | None = None, *, pushed: bool = True) -> TrackFile:
    """Return the track of a file's first point.

    A time without unit is in s. Rows with an empty place are left out.

    Parameters
    ----------
    path
        The file.
    unit
        Of lengths whose column names none: one of LENGTH_UNITS.
    pushed
        It is a track of a push, as fast and as long as those are.

    Raises
    ------
    BadInput
        A unit is missing or is none of time or length, or a cell is no number; the message names
        the line, and what to change.
    """
    if unit is not None:
        check_choice("unit", unit, tuple(LENGTH_UNITS))
    table, columns = read_table(path, _columns, NEEDED)
    time, x = columns[:2]
    rows = _seen(table, columns)
    with located(str(path)):
        units = [column.length_unit or unit for column in columns[1:]]
        scale = time.time_s
    track = np.zeros((len(rows), 3))
    factors = [scale, *(LENGTH_UNITS[each or "m"] for each in units)]
    for row, (line, texts) in zip(track, rows, strict=True):
        for k, (text, column) in enumerate(zip(texts, columns, strict=True)):
            row[k] = factors[k] * _value(table, line, text, column.name)
    with located(str(path)):
        if len(track) < FEWEST_PLACES:
            raise BadInput(f"{len(track)} place(s) in it; is it a track of time, x and y?")
        _check_times(track[:, 0], time)
        track = track[np.concatenate([[True], np.diff(track[:, 0]) != 0.0])]
        if None in units:
            likely = likely_units(*speed_and_way(track)) if pushed else []
            some = f"; likely: {', '.join(likely)}" if likely else ""
            raise BadInput(
                f"its lengths have no unit ({x.name}); say it, by --unit or behind the file's name "
                f"at the prompt: one of {', '.join(LENGTH_UNITS)}{some}"
            )
        if pushed:
            _check_size(track, units[0] or "m", x)
    notes = []
    if sum(Column.of(0, cell).meaning == "x" for cell in table.head) > 1:
        notes.append(f"{path.name}: the first point, {x.name}, is taken; the others are left out")
    if len(columns) < 3:
        notes.append(f"{path.name}: no column y; the track is taken as straight along x")
    return TrackFile(track, hashlib.sha256(table.text.encode()).hexdigest(), tuple(notes))


def _seen(table: TextTable, columns: list[Column]) -> list[tuple[int, list[str]]]:
    """Return lines and cells of the rows in which no column of the track is empty."""
    width = 1 + max(column.place for column in columns)
    rows = [
        (line, [cells[c.place] for c in columns])
        for line, cells in table.rows
        if len(cells) >= width
    ]
    return [(line, texts) for line, texts in rows if EMPTY_CELLS.isdisjoint(texts)]


def speed_and_way(track: Floats) -> tuple[float, float]:
    """Return the speed that a track exceeds for FAST_S in all, m/s, and its extent, m.

    So a place that was mistaken for another does not count.
    """
    order = np.argsort(-(rates := speeds(*track.T)))
    shares = np.gradient(track[:, 0])[order]
    fast = min(int(np.searchsorted(np.cumsum(shares), FAST_S)), len(rates) - 1)
    ends = np.quantile(track[:, 1:], (0.02, 0.98), axis=0)
    return float(rates[order][fast]), float(np.hypot(*(ends[1] - ends[0])))


def _check_size(track: Floats, unit: str, column: Column) -> None:
    """Raise BadInput for a track that is too fast, too long or too slow for a push."""
    speed_m_s, way_m = speed_and_way(track)
    told = unlikely_push(speed_m_s, way_m, unit)
    if not told and speed_m_s < MOVES_M_S and (units := likely_units(speed_m_s, way_m, unit)):
        told = (
            f"{way_m:.2g} m at {speed_m_s:.2g} m/s at most is no push; likely instead of {unit}: "
            f"{', '.join(units)}"
        )
    if told:
        where = "give another --unit" if column.unit is None else f"correct the name {column.name}"
        raise BadInput(f"{told}; {where}, or the scale")


def _value(table: TextTable, line: int, text: str, name: str) -> float:
    try:
        return table.number(text)
    except ValueError:
        clock = f"; {TIME_ADVICE}" if ":" in text else ""
        raise BadInput(f"{table.where(line)}: {name} is {text!r}, not a number{clock}") from None


def _check_times(t: Floats, column: Column) -> None:
    """Raise BadInput where times cannot be seconds, or what their unit says."""
    steps = np.diff(t)
    if not (steps > 0.0).any() or (steps < 0.0).any():
        raise BadInput(f"the times in {column.name} do not rise; {TIME_ADVICE}")
    step, doubt = float(np.median(steps[steps > 0.0])), ""
    if column.unit is None and step > MOST_STEP_S:
        what = "pictures" if np.all(steps == np.round(steps)) else "ms"
        doubt = f"has no unit and rises by {step:.4g} from one place to the next, like {what}"
    elif column.unit is None and t[0] == 0.0 and abs(t[-1] - 1.0) < 1e-6:
        doubt = "has no unit and runs from 0 to 1, like a normalized time"
    elif step < LEAST_STEP_S:
        doubt = f"says {1 / step:.3g} pictures a second: its unit is wrong"
    if doubt:
        raise BadInput(f"{column.name} {doubt}; {TIME_ADVICE}")
