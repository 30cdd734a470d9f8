"""Tracks made by other programs: Tracker's, Kinovea's and plain CSV files of time and place."""

from __future__ import annotations

import hashlib
import math
import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ...model.checks import check_choice
from ...model.errors import BadInput
from ...model.files import read_text

UNITS = {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254}
_TIMES = {"s": 1.0, "ms": 0.001, "min": 60.0}
_CLOCK = re.compile(r"(\d+):(\d\d):(\d\d)[:.](\d+)")
_UNIT = re.compile(r"[(\[]\s*(\w+)\s*[)\]]")
_TIME_NAMES = re.compile(r"(?i)^#?(t|time|t_s|timestamp)\b")
GRAIN_S = 0.01  # of Kinovea's clock


def read_track_file(path: Path, unit: str = "m") -> tuple[NDArray[np.float64], str]:
    """Return t_s, x_m, y_m (rows, 3) of a file's first point, and the file's SHA-256.

    Columns are told by their names: a time (t, time, ...), then the first x and the first y after
    it; y may be missing. Units may stand in the names, as in `Time (ms)` and `x (cm)`; else times
    are s, or a clock as Kinovea's h:mm:ss:cc, and lengths are `unit`. Times in whole hundredths
    become those of even pictures where they can be. Rows with an empty place are
    left out. Raises BadInput, naming the line.
    """
    check_choice("unit", unit, tuple(UNITS))
    text = read_text(path)
    lines = text.replace("\r\n", "\n").split("\n")
    cut = _delimiter(lines)
    head, columns = _header(path, lines, cut)
    rows: list[tuple[float, float, float]] = []
    for number, line in enumerate(lines[head + 1 :], head + 2):
        cells = _cells(line, cut)
        if not any(cells):
            if rows and lines[head].startswith("#"):
                break  # Kinovea's text form puts an empty line between points
            continue
        row = _row(path, number, cells, columns, cut)
        if row is not None:
            rows.append(row)
    if len(rows) < 3:
        raise BadInput(f"{path}: {len(rows)} place(s) in it; is it a track of time, x and y?")
    (_, in_s), *places = columns
    found = np.array(rows)
    found[:, 0] = _unrounded(found[:, 0] * (in_s or 1.0))
    for k, (_, in_m) in enumerate(places, 1):
        found[:, k] *= in_m or UNITS[unit]
    digest = hashlib.sha256(text.encode()).hexdigest()
    return found[np.concatenate([[True], np.diff(found[:, 0]) > 0.0])], digest


def _unrounded(t: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return times as they were before a clock of whole hundredths cut them, s.

    Pictures come evenly, pictures without a place counted. Where no even line is within a hundredth
    of all times, or a picture is as short as that, they stay as they are.
    """
    steps = np.diff(t)
    whole = np.abs(100 * t - np.round(100 * t)).max(initial=0.0) < 1e-6
    if not whole or len(t) < 10 or np.median(steps) < 2 * GRAIN_S:
        return t
    one = steps[steps < 1.5 * np.median(steps)].mean()
    count = np.concatenate([[0.0], np.cumsum(np.round(steps / one))])
    slope, start = np.polyfit(count, t, 1).tolist()
    even: NDArray[np.float64] = start + slope * count
    return even if np.ptp(t - even) <= 1.2 * GRAIN_S else t


def _delimiter(lines: list[str]) -> str:
    """Return what parts the cells: tabs before semicolons before commas, which may be decimals."""
    sample = "\n".join(lines[:40])
    named = next((line for line in lines[:20] if _TIME_NAMES.match(line)), "")
    if "\t" not in sample and len(named.split()) > 2 and not re.search("[,;]", named):
        return " "  # commas in it are decimals
    return next((cut for cut in "\t;," if sample.count(cut) > 2), " ")


def _cells(line: str, cut: str) -> list[str]:
    parts = line.split() if cut == " " else line.split(cut)
    return [part.strip().strip('"') for part in parts]


def _header(path: Path, lines: list[str], cut: str) -> tuple[int, list[tuple[int, float | None]]]:
    """Return the header's line and where t, x and y are, with their units where they are named."""
    for k, line in enumerate(lines[:20]):
        cells = _cells(line, cut)
        at = next((i for i, c in enumerate(cells) if _TIME_NAMES.match(c)), None)
        if at is None:
            continue
        x = next((i for i in range(at + 1, len(cells)) if _is_place(cells[i], "x")), None)
        if x is None:
            continue
        y = next((i for i in range(x + 1, len(cells)) if _is_place(cells[i], "y")), None)
        out = [(at, _named_unit(cells[at], _TIMES)), (x, _named_unit(cells[x], UNITS))]
        return k, out + ([] if y is None else [(y, _named_unit(cells[y], UNITS))])
    raise BadInput(
        f"{path}: no line names its columns; the first must be such as t,x,y (Tracker: export with "
        "the column names; Kinovea: export trajectories as text, or the diagram's data)"
    )


def _is_place(name: str, axis: str) -> bool:
    bare = _UNIT.sub("", name).strip().lower()
    return bare in (axis, f"{axis}_m") or bool(re.search(rf"[/ _]{axis}(_m)?$", bare))


def _named_unit(name: str, known: dict[str, float]) -> float | None:
    found = _UNIT.search(name)
    return known.get(found[1].lower()) if found else None


def _row(
    path: Path, number: int, cells: list[str], columns: list[tuple[int, float | None]], cut: str
) -> tuple[float, float, float] | None:
    texts = [cells[at] for at, _ in columns if at < len(cells)]
    if len(texts) < len(columns) or not all(texts):
        return None
    try:
        t, x, y = [*(_number(text, cut) for text in texts), 0.0][:3]
    except ValueError:
        raise BadInput(f"{path}:{number}: {', '.join(texts)} are not numbers") from None
    return (t, x, y) if all(map(math.isfinite, (t, x, y))) else None


def _number(text: str, cut: str) -> float:
    """Return a number, or a clock's time in s."""
    clock = _CLOCK.fullmatch(text)
    if clock is None:
        return float(text if cut == "," else text.replace(",", "."))
    hours, minutes, seconds, rest = clock.groups()
    return 3600 * int(hours) + 60 * int(minutes) + int(seconds) + int(rest) / 10 ** len(rest)
