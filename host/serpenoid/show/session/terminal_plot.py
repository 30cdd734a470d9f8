"""Curves in a terminal's characters; a session's belt speeds against inclines."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from ...calibration.taking.expected import Series, line_of, series_it_is_of, series_of

if TYPE_CHECKING:
    from ...calibration.session import Session

Axes = tuple[str, str, str]  # unit upright, unit along, and what the marks mean
Curve = tuple[ArrayLike, ArrayLike, str]  # along, upright, and the mark of each point
MARKS = "ox+*#@"
WIDE, HIGH = 64, 14


def picture(session: Session) -> str:
    """Return belt speed against incline, a mark a bend and dots for its line; "" without two."""
    plan, procedure = _shown(session), session.setup.procedure
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
        line = line_of(session, series.lambda_rad, series.facing) if planned else None
        if line is not None:
            law = [line.at(math.sin(math.radians(incline)))[0] for incline in every]
            curves.append((every, law, "·"))
    for incline, speed, r in zip(incline_deg, speeds, session.kept, strict=True):
        bend = plan.index(series_it_is_of(session, r))
        curves.append(([incline], [speed], MARKS[bend % len(MARKS)]))
    named = "   ".join(f"{MARKS[k % len(MARKS)]} {series.name}" for k, series in enumerate(plan))
    return chart(curves, (low, high), 1.08 * max(speeds), ("m/s", "deg of incline", named))


def _shown(session: Session) -> list[Series]:
    """Return the plan's series, and those of readings that the plan does not ask for."""
    there = [series_it_is_of(session, r) for r in session.kept]
    return list(dict.fromkeys([*series_of(session.setup.procedure), *there]))


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
