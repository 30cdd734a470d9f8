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
_NAMED_UNITS = UNITS | {"s": 1.0, "ms": 0.001, "min": 60.0}
_CLOCK = re.compile(r"(\d+):(\d\d):(\d\d)[:.](\d+)")
_UNIT = re.compile(r"[(\[]\s*(\w+)\s*[)\]]")
# Names of the columns wanted, in this order, their units taken off; the last may be missing.
_TIME = r"(?i)#?(t|time|t_s|timestamp)\b"
_WANTED = (_TIME, *(rf"(?i)(.*[/ _])?{axis}(_m)?$" for axis in "xy"))
GRAIN_S = 0.01  # of Kinovea's clock
Columns = list[tuple[int, float | None]]  # where each is, and its unit where it is named


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
    lines = text.split("\n")
    cut = _delimiter(lines)
    head, columns = _header(path, lines, cut)
    usual = (1.0, UNITS[unit], UNITS[unit])
    scales = [named or other for (_, named), other in zip(columns, usual, strict=False)]
    rows = []
    for number, line in enumerate(lines[head + 1 :], head + 2):
        cells = _cells(line, cut)
        if not any(cells) and rows and lines[head].startswith("#"):
            break  # Kinovea's text form puts an empty line between points
        texts = [cells[at] for at, _ in columns if at < len(cells)]
        if len(texts) < len(columns) or not all(texts):
            continue
        try:
            row = [scale * _number(t, cut) for scale, t in zip(scales, texts, strict=True)]
        except ValueError:
            raise BadInput(f"{path}:{number}: {', '.join(texts)} are not numbers") from None
        if all(map(math.isfinite, row)):
            rows.append([*row, 0.0][:3])
    if len(rows) < 3:
        raise BadInput(f"{path}: {len(rows)} place(s) in it; is it a track of time, x and y?")
    track = np.array(rows)
    track[:, 0] = _unrounded(track[:, 0])
    digest = hashlib.sha256(text.encode()).hexdigest()
    return track[np.concatenate([[True], np.diff(track[:, 0]) > 0.0])], digest


def _unrounded(t: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return times as they were before a clock of whole hundredths cut them, s.

    Pictures come evenly, pictures without a place counted. Where no even line is within a hundredth
    of all times, or a picture is as short as that, they stay as they are.
    """
    steps = np.diff(t)
    whole = np.abs(100 * t - np.round(100 * t)).max(initial=0.0) < 1e-6
    if not whole or len(t) < 10 or np.median(steps) < 2 * GRAIN_S:
        return t
    step_s = steps[steps < 1.5 * np.median(steps)].mean()
    count = np.concatenate([[0.0], np.cumsum(np.round(steps / step_s))])
    even = np.asarray(np.polyval(np.polyfit(count, t, 1), count), dtype=np.float64)
    return even if np.ptp(t - even) <= 1.2 * GRAIN_S else t


def _delimiter(lines: list[str]) -> str:
    """Return what parts the cells: tabs before semicolons before commas, which may be decimals."""
    sample = "\n".join(lines[:40])
    named = next((line for line in lines[:20] if re.match(_TIME, line)), "")
    if "\t" not in sample and len(named.split()) > 2 and not re.search("[,;]", named):
        return " "  # commas in it are decimals
    return next((cut for cut in "\t;," if sample.count(cut) > 2), " ")


def _cells(line: str, cut: str) -> list[str]:
    parts = line.split() if cut == " " else line.split(cut)
    return [part.strip().strip('"') for part in parts]


def _header(path: Path, lines: list[str], cut: str) -> tuple[int, Columns]:
    """Return the header's line and where t, x and y are; raises BadInput."""
    for k, line in enumerate(lines[:20]):
        columns: Columns = []
        names = iter(enumerate(_cells(line, cut)))
        for wanted in _WANTED:
            for at, name in names:
                if re.match(wanted, _UNIT.sub("", name).strip()):
                    unit = _UNIT.search(name)
                    columns.append((at, _NAMED_UNITS.get(unit[1].lower()) if unit else None))
                    break
        if len(columns) > 1:
            return k, columns
    raise BadInput(
        f"{path}: no line names its columns; the first must be such as t,x,y (Tracker: export with "
        "the column names; Kinovea: export trajectories as text, or the diagram's data)"
    )


def _number(text: str, cut: str) -> float:
    """Return a number, or a clock's time in s."""
    clock = _CLOCK.fullmatch(text)
    if clock is None:
        return float(text if cut == "," else text.replace(",", "."))
    hours, minutes, seconds, rest = clock.groups()
    return 3600 * int(hours) + 60 * int(minutes) + int(seconds) + int(rest) / 10 ** len(rest)
