"""Tracks made by other programs: Tracker's, Kinovea's and plain tables of time and place."""

from __future__ import annotations

import hashlib
import math
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..base.checks import check_choice
from ..base.errors import BadInput
from ..base.tables import TextTable, is_missing, read_table
from ..base.toml_table import located
from ..calibration.floor.look import MOVES_M_S, speeds
from ..session.declaration import LENGTH_UNITS
from ..session.push_size import likely_units, unlikely_push
from .track_columns import NEEDED, TIME_ADVICE, Column, TrackColumns, track_columns

Floats = NDArray[np.float64]
_CLOCK = re.compile(r"(?:(\d+):)?(\d+):(\d\d)(?:[:.,](\d+))?(?:\s*\(\d+\))?")
CLOCK_STEP_S = 0.01  # of Kinovea's clock
MOST_FRAMES_A_SECOND = 60  # that a timecode of hours, minutes, seconds and pictures counts
LEAST_STEP_S = 1 / 2000  # between two pictures: no camera of a phone is faster
FAST_S = 0.1  # a push is at its fastest for longer than this
MOST_STEP_S = 0.5  # between two pictures of a push, where the time has no unit
FEWEST_PLACES = 3


@dataclass(frozen=True)
class TrackFile:
    """Hold t_s, x_m, y_m (rows, 3) of one point, the file's SHA-256, and what is to be told."""

    values: Floats
    sha256: str
    notes: tuple[str, ...] = ()


def read_track_file(path: Path, unit: str | None = None) -> TrackFile:
    """Return the track of a file's first point.

    Columns are told by their names: a time, and x and y of one point; y may be missing. Units stand
    in the names, as in `Time (ms)` and `x (cm)`. A time without one is in s, or a clock as
    Kinovea's h:mm:ss:cc. Times in whole hundredths become those of even pictures where they can be.
    Rows with an empty place are left out.

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
    table, columns = read_table(path, track_columns, NEEDED)
    kept = [columns.time, columns.x, *([columns.y] if columns.y else [])]
    with located(str(path)):
        units = [column.length_unit or unit for column in kept[1:]]
        cells, point, others = _rows_of_first_point(table, columns, [c.place for c in kept])
    times = _times_s(table, columns.time, cells)
    places = [[_value(table, line, text) for text in texts[1:]] for line, texts in cells]
    if len(times) < FEWEST_PLACES:
        raise BadInput(f"{path}: {len(times)} place(s) in it; is it a track of time, x and y?")
    track = np.zeros((len(times), 3))
    track[:, 0] = times
    track[:, 1 : len(kept)] = np.array(places) * [LENGTH_UNITS[name or "m"] for name in units]
    with located(str(path)):
        _check_times(track[:, 0], columns.time, cells)
        track = track[np.concatenate([[True], np.diff(track[:, 0]) != 0.0])]
        track[:, 0] = _without_rounding(track[:, 0])
    if None in units:
        raise UnitMissing(path, columns.x.name, track)
    with located(str(path)):
        _check_size(track, units[0] or "m", columns.x)
    notes = []
    if others:
        notes.append(
            f"{path.name}: the point {point or columns.x.name!r} is taken; {', '.join(others)} "
            "in the same file is left out"
        )
    if columns.y is None:
        notes.append(f"{path.name}: no column y; the track is taken as straight along x")
    if columns.x.unit is not None and unit not in (None, *units):
        notes.append(f"{path.name}: its lengths are in {units[0]}, as it says; not in {unit}")
    return TrackFile(track, hashlib.sha256(table.text.encode()).hexdigest(), tuple(notes))


class UnitMissing(BadInput):
    """A table names no unit of length; `likely` has what the track would be in likely ones."""

    def __init__(self, path: Path, column: str, track: Floats):
        self.likely = likely_units(*speed_and_way(track))
        some = f"; likely: {', '.join(self.likely)}" if self.likely else ""
        super().__init__(
            f"{path}: its lengths have no unit ({column}); say it: --unit with one of "
            f"{', '.join(LENGTH_UNITS)}{some}"
        )


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


def _rows_of_first_point(
    table: TextTable, columns: TrackColumns, places: list[int]
) -> tuple[list[tuple[int, list[str]]], str, list[str]]:
    """Return line and cells of each place of the first point, its name, and those of others.

    Kinovea's text form has its points one after the other, a blank line or a name between.
    """
    rows: list[tuple[int, list[str]]] = []
    point, others = columns.x.point or _name_above(table, columns.x.place), list(columns.others)
    in_parts = table.head[0].startswith("#")
    ended = False
    for line, cells in table.rows:
        name = " ".join(cells).lstrip("# ") if cells and cells[0].startswith("#") else ""
        if in_parts and rows and (name or not any(cells)):
            ended = True
        if name:
            if ended:
                others.append(name)
            else:
                point = name
            continue
        texts = [cells[place] if place < len(cells) else "" for place in places]
        if any(is_missing(text) for text in texts):
            continue
        if not ended:
            rows.append((line, texts))
        elif not others:
            others.append("another point")
    return rows, point, others


def _name_above(table: TextTable, place: int) -> str:
    """Return the name of a point as Tracker writes it: above its first column."""
    names = [cell for cell in table.above[: place + 1] if cell]
    return names[-1] if names and not table.head[0].startswith("#") else ""


def _value(table: TextTable, line: int, text: str) -> float:
    try:
        value = table.number(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise BadInput(f"{table.where(line)}: {text!r} is not a number")
    return value


def _times_s(table: TextTable, column: Column, cells: list[tuple[int, list[str]]]) -> list[float]:
    """Return the times of rows; raises BadInput."""
    if cells and all(_CLOCK.fullmatch(texts[0]) for _, texts in cells):
        return [_clock_s(texts[0]) for _, texts in cells]
    with located(str(table.path)):
        scale = column.time_s or 1.0
    return [scale * _value(table, line, texts[0]) for line, texts in cells]


def _clock_s(text: str) -> float:
    """Return the time of a clock, s."""
    match = _CLOCK.fullmatch(text)
    assert match is not None
    hours, minutes, seconds, rest = match.groups()
    fraction = int(rest) / 10 ** len(rest) if rest else 0.0
    return 3600 * int(hours or 0) + 60 * int(minutes) + int(seconds) + fraction


def _check_times(t: Floats, column: Column, cells: list[tuple[int, list[str]]]) -> None:
    """Raise BadInput where times cannot be seconds, or what their unit says."""
    steps = np.diff(t)
    steps = steps[steps > 0]
    if not len(steps):
        raise BadInput(f"the times in {column.name} do not rise; {TIME_ADVICE}")
    falls = np.flatnonzero(np.diff(t) < 0.0)
    if len(falls):
        raise BadInput(
            f"times must rise: {t[falls[0] + 1]:.6g} s comes after {t[falls[0]]:.6g} s in "
            f"{column.name}; is that the time?"
        )
    step = float(np.median(steps))
    clocks = [_CLOCK.fullmatch(texts[0]) for _, texts in cells]
    if clocks[0]:
        ends = [match[4] for match in clocks if match and match[4]]
        counts_frames = (
            ends and max(map(len, ends)) == 2 and max(map(int, ends)) < (MOST_FRAMES_A_SECOND)
        )
        if counts_frames and t[-1] - t[0] > 1.0 and step < 1.5 * CLOCK_STEP_S:
            raise BadInput(f"the clock in {column.name} counts pictures; {TIME_ADVICE}")
        return
    if column.unit is None and step > MOST_STEP_S:
        what = "pictures" if np.all(steps == np.round(steps)) else "ms"
        raise BadInput(
            f"{column.name} has no unit and rises by {step:.4g} from one place to the next: it "
            f"looks like {what}, not s; {TIME_ADVICE}"
        )
    if column.unit is None and t[0] == 0.0 and abs(t[-1] - 1.0) < 1e-6:
        raise BadInput(
            f"{column.name} has no unit and runs from 0 to 1: it looks like a normalized time; "
            f"{TIME_ADVICE}"
        )
    if step < LEAST_STEP_S:
        raise BadInput(
            f"{column.name} says {1 / step:.3g} pictures a second: its unit is wrong; {TIME_ADVICE}"
        )


def _without_rounding(t: Floats) -> Floats:
    """Return times as they were before a clock of whole hundredths cut them, s.

    Pictures come evenly, pictures without a place counted. Where no even line is within a hundredth
    of all times, or a picture is as short as that, they stay as they are.
    """
    steps = np.diff(t)
    whole = np.abs(100 * t - np.round(100 * t)).max(initial=0.0) < 1e-6
    if not whole or len(t) < 10 or np.median(steps) < 2 * CLOCK_STEP_S:
        return t
    step_s = steps[steps < 1.5 * np.median(steps)].mean()
    count = np.concatenate([[0.0], np.cumsum(np.round(steps / step_s))])
    even = np.asarray(np.polyval(np.polyfit(count, t, 1), count), dtype=np.float64)
    return even if np.ptp(t - even) <= 1.2 * CLOCK_STEP_S else t
