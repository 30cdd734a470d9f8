"""Which columns of an exported track are time, x and y of one point, and in which units.

Names are those that Tracker, Kinovea (in its languages) and people give: `t`, `Time (ms)`,
`Trajectory 1/X (cm)`, `x_m`. A unit that is no unit of time or length is refused, never dropped.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

from ..base.errors import BadInput
from ..session.declaration import LENGTH_UNITS

TIME_UNITS = {
    "s": 1.0,
    "ms": 1e-3,
    "μs": 1e-6,
    "min": 60.0,
    "min/100": 0.6,
    "hour/10000": 0.36,
}
NEEDED = "t_s,x_m,y_m, or as in Time (ms);Trajectory 1/X (cm);Trajectory 1/Y (cm)"
# What a column is -> words for it; those of a time in Kinovea's languages.
WORDS = {
    "t": "t time timestamp temps zeit tiempo tempo tid tijd czas čas vreme vrijeme време время "
    "час χρόνος aika zaman waktu masa timp laikas idő 時間 时间 시간 เวลา زمان الزمن thời",
    "frame": "n frame frames step image picture bild",
    "rate": "v vel velocity speed acc accel acceleration",
}
_MEANING = {word.casefold(): meaning for meaning, words in WORDS.items() for word in words.split()}
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
_UNIT = {word: unit for unit, words in SPELLINGS.items() for word in (unit, *words.split())}
_UNIT |= {unit: unit for unit in TIME_UNITS}
_IN_BRACKETS = re.compile(r"[(\[{]\s*([^()\[\]{}]*?)\s*[)\]}]\s*$")
_WORDS = re.compile(r"[\s/_.,:;#|()-]+")
_AXIS = re.compile(r"(?:pos|position|coord)?([xy])(?:pos|position|coord)?\d*")
_OF_A_RATE = re.compile(r"[vapl]_", re.IGNORECASE)  # as in Tracker's v_x, a_x, p_x


@dataclass(frozen=True)
class Column:
    """Hold where a column is, its name as written, what it is ("t", "x", "y", "frame" or ""),
    the name of its point, and its unit as written, None where none is.
    """

    place: int
    name: str
    axis: str
    point: str
    unit: str | None

    @property
    def length_unit(self) -> str | None:
        """Return its unit, a key of LENGTH_UNITS; None if it names none. Raises BadInput."""
        if self.unit is None:
            return None
        unit = _UNIT.get(self.unit.casefold(), "")
        if unit in LENGTH_UNITS:
            return unit
        raise BadInput(
            f"{self.name} is in {self.unit or 'an empty unit'!r}, which is no length; set the "
            "scale and export again (Tracker: Track > New > Calibration Tools; Kinovea: "
            "draw a line of known length, right-click it, Calibrate); units that are read: "
            f"{', '.join(LENGTH_UNITS)}"
        )

    @property
    def time_s(self) -> float | None:
        """Return the duration of its unit, s; None if it names none. Raises BadInput."""
        if self.unit is None and self.axis == "t":
            return None
        unit = _UNIT.get((self.unit or "frames").casefold(), "")
        if unit in TIME_UNITS:
            return TIME_UNITS[unit]
        raise BadInput(
            f"{self.name} is no time in seconds but in {self.unit or 'pictures'}; {TIME_ADVICE}"
        )


TIME_ADVICE = (
    "export the time in s or ms (Tracker: take t as the first column; Kinovea: milliseconds as "
    "the time format in its preferences, and no normalized time), or, if it is in s, name the "
    "column Time (s)"
)


@dataclass(frozen=True)
class TrackColumns:
    """Hold the columns of one point's track; y is None where the file has none.

    others: the names of the points that are left out.
    """

    time: Column
    x: Column
    y: Column | None
    others: tuple[str, ...]


def column_of(place: int, cell: str) -> Column:
    """Return what the name of a column says."""
    bracket = _IN_BRACKETS.search(cell)
    unit = bracket[1] if bracket else None
    name = cell[: bracket.start()].strip() if bracket else cell.strip()
    words = [word for word in _WORDS.split(name) if word]
    if bracket is None and len(words) > 1 and words[-1].casefold() in _UNIT:
        unit = words.pop()
        name = name[: name.rindex(unit)].rstrip(" _/.,:;-")
        if words[-1].casefold() == "in" and len(words) > 1:  # as in "x in cm"
            words.pop()
    plain = [word.casefold() for word in words]
    if not plain:
        return Column(place, cell, "", "", unit)
    meanings = [_MEANING.get(word) for word in plain]
    if "t" in (meanings[0], meanings[-1]):
        return Column(place, cell, "t", "", unit)
    if meanings == ["frame"]:
        return Column(place, cell, "frame", "", "frames")
    if "rate" in meanings or _OF_A_RATE.match(name):
        return Column(place, cell, "", "", unit)
    for word, rest in ((plain[-1], words[:-1]), (plain[0], [])):
        if axis := _AXIS.fullmatch(word):
            return Column(place, cell, axis[1], _point(name, rest), unit)
    return Column(place, cell, "", "", unit)


def _point(name: str, words: list[str]) -> str:
    """Return the name of a point: that of a column up to its last word."""
    if not words:
        return ""
    return name[: name.index(words[-1], max(name.rfind(words[-1]), 0)) + len(words[-1])].strip("# ")


def track_columns(head: list[str]) -> TrackColumns | None:
    """Return the columns of the first point in a line of names; None without time and x."""
    columns = [column_of(place, cell) for place, cell in enumerate(head)]
    times = [column for column in columns if column.axis == "t"]
    times = times or [column for column in columns if column.axis == "frame"]
    along = [column for column in columns if column.axis == "x"]
    if not times or not along:
        return None
    x = along[0]
    across = [column for column in columns if column.axis == "y"]
    same = [column for column in across if column.point == x.point] or across
    others = tuple(column.point or column.name for column in along[1:])
    return TrackColumns(times[0], x, same[0] if same else None, others)
