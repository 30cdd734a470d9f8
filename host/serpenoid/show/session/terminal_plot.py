"""Curves in a terminal's characters: belt speeds against inclines, and the places of a push."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from ...calibration.floor.arc import along
from ...calibration.floor.look import look_at
from ...calibration.kinds.coast import Coast
from ...calibration.session import Session
from ...calibration.taking.expected import line_of, series_it_is_of, series_of
from ...model.errors import BadInput

Axes = tuple[str, str, str]  # unit upright, unit along, and what the marks mean
Curve = tuple[ArrayLike, ArrayLike, str]  # along, upright, and the mark of each point
MARKS = "ox+*#@"
WIDE, HIGH = 64, 14


def picture(session: Session) -> str:
    """Return belt speed against incline, a mark a bend and dots for its line; "" without two."""
    procedure = session.setup.procedure
    # the plan's, and those of readings that it does not ask for
    there = [series_it_is_of(session, r) for r in session.kept]
    plan = list(dict.fromkeys([*series_of(procedure), *there]))
    sines = [r.balance_sine(procedure.gravity_m_s2) for r in session.kept]
    if len(sines) < 2:
        return ""
    incline_deg = np.degrees(np.arcsin(sines))
    low, high = float(incline_deg.min()) - 0.2, float(incline_deg.max()) + 0.2
    speeds = [r.slip_speed_m_s for r in session.kept]
    every = np.linspace(low, high, WIDE)
    curves: list[Curve] = []
    for series in plan:
        planned = series.bend == procedure.bend
        line = line_of(session, series) if planned else None
        if line is not None:
            law = [line.at(math.sin(math.radians(incline)))[0] for incline in every]
            curves.append((every, law, "·"))
    for incline, speed, series in zip(incline_deg, speeds, there, strict=True):
        bend = plan.index(series)
        curves.append(([incline], [speed], MARKS[bend % len(MARKS)]))
    named = "   ".join(f"{MARKS[k % len(MARKS)]} {series.name}" for k, series in enumerate(plan))
    return chart(curves, (low, high), 1.08 * max(speeds), ("m/s", "deg of incline", named))


def chart(
    curves: Sequence[Curve], ends: tuple[float, float], top: float, axes: Axes, rows: int = HIGH
) -> str:
    """Return curves with their axes, along between two ends and upright from 0 up to top.

    Later curves cover earlier ones; points outside are left out.
    """
    (low, high), (upright, along, legend) = ends, axes
    grid = np.full((rows, WIDE), " ")
    for x, y, mark in curves:
        column = np.rint((np.asarray(x) - low) / (high - low) * (WIDE - 1)).astype(int)
        row = rows - 1 - np.rint(np.asarray(y) / top * (rows - 1)).astype(int)
        inside = (column >= 0) & (column < WIDE) & (row >= 0) & (row < rows)
        grid[row[inside], column[inside]] = mark
    left = [f"{top:6.2f} │", *["       │"] * (rows - 2), f"{0:6.2f} │"]
    lines = [start + "".join(cells) for start, cells in zip(left, grid, strict=True)]
    first = f"{low:.1f}"
    lines += [
        f"{upright:>6} └" + "─" * WIDE,
        f"        {first}{high:>{WIDE - len(first)}.1f} {along}",
        f"        {legend}",
    ]
    return "\n".join(lines)


PUSH_HIGH = 9
LEVELS = "▁▂▃▄▅▆▇█"
LEAST_MM = 1.0  # off the law, at either end of LEVELS: where less is off, it is noise


def push_picture(push: Coast) -> str:
    """Return the part that counts of a followed push with a law of its own; "" if none is there.

    The law has the frictions that fit this push alone, so that a kink or a wobble shows.
    """
    if push.track is None or push.by != "film":
        return ""
    track = np.asarray(push.track.values)
    try:
        look = look_at(*track.T)
    except BadInput:
        return ""
    t, x, y = track[(track[:, 0] >= look.start_s) & (track[:, 0] <= look.end_s)].T
    way = along(x, y, look.sigma_m)
    t, way = t - t[0], way - way[0]
    end_s = float(t[-1])
    every = np.linspace(0.0, end_s, WIDE)
    law_m = np.interp(every, t, look.law_m)
    top = max(1.05 * float(max(way.max(), law_m.max())), 1e-3)
    curves = [(every, law_m, "·"), (t, np.clip(way, 0.0, None), "o")]
    column = np.rint(t / end_s * (WIDE - 1)).astype(int)
    legend = f"o push {push.number}, {push.way}   · law of this push alone"
    # a character a column: its mean distance off the law
    count = np.bincount(column, minlength=WIDE)
    mean = np.bincount(column, 1000 * (way - look.law_m), WIDE) / np.maximum(count, 1)
    most = max(float(np.abs(mean).max()), LEAST_MM)
    level = np.rint((mean / most + 1) / 2 * (len(LEVELS) - 1)).astype(int)
    strip = "".join(LEVELS[k] if n else " " for k, n in zip(level, count, strict=True))
    strip += f"\n        off the law: {LEVELS[0]} {-most:.2g} to {LEVELS[-1]} {most:+.2g} mm"
    return chart(curves, (0.0, end_s), top, ("m", "s", f"{legend}\n        {strip}"), PUSH_HIGH)
