"""A session's points and lines in a terminal's characters: belt speed against incline."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from ...calibration.taking.expected import Series, line_of, series_it_is_of, series_of

if TYPE_CHECKING:
    from ...calibration.session import Session

Axes = tuple[str, str, str]  # unit upright, unit along, and what the marks mean
MARKS = "ox+*#@"
WIDE, HIGH = 64, 14


def picture(session: Session) -> str:
    """Return belt speed against incline, a mark a bend and dots for its line; "" without two."""
    plan = _shown(session)
    points = []
    for r in session.kept:
        bend = plan.index(series_it_is_of(session, r))
        sine = r.balance_sine(session.setup.procedure.gravity_m_s2)
        points.append((math.degrees(math.asin(sine)), r.slip_speed_m_s, bend))
    if len(points) < 2:
        return ""
    low, high = min(p[0] for p in points) - 0.2, max(p[0] for p in points) + 0.2
    top = 1.08 * max(p[1] for p in points)
    grid = [[" "] * WIDE for _ in range(HIGH)]

    def put(incline_deg: float, speed: float, mark: str) -> None:
        x = round((incline_deg - low) / (high - low) * (WIDE - 1))
        y = HIGH - 1 - round(speed / top * (HIGH - 1))
        if 0 <= x < WIDE and 0 <= y < HIGH:
            grid[y][x] = mark

    for series in plan:
        planned = series.bend == session.setup.procedure.bend
        line = line_of(session, series.lambda_rad, series.facing) if planned else None
        for k in range(WIDE if line else 0):
            incline = low + (high - low) * k / (WIDE - 1)
            assert line is not None  # or the range is empty
            put(incline, line.at(math.sin(math.radians(incline)))[0], "·")
    for incline, speed, bend in points:
        put(incline, speed, MARKS[bend % len(MARKS)])
    return framed(grid, low, high, top, ("m/s", "deg of incline", _named(session)))


def _shown(session: Session) -> list[Series]:
    """Return the plan's series, and those of readings that the plan does not ask for."""
    there = [series_it_is_of(session, r) for r in session.kept]
    return list(dict.fromkeys([*series_of(session.setup.procedure), *there]))


def _named(session: Session) -> str:
    return "   ".join(f"{MARKS[k % len(MARKS)]} {x.name}" for k, x in enumerate(_shown(session)))


def framed(grid: list[list[str]], low: float, high: float, top: float, axes: Axes) -> str:
    """Return rows of characters with their axes: from low to high, and from 0 up to top."""
    upright, along, legend = axes
    wide = len(grid[0])
    lines = [f"{top:6.2f} │" + "".join(grid[0])]
    lines += ["       │" + "".join(row) for row in grid[1:-1]]
    lines += [f"{0:6.2f} │" + "".join(grid[-1]), f"{upright:>6} └" + "─" * wide]
    left = f"{low:.1f}"
    lines.append(f"        {left}{high:>{wide - len(left)}.1f} {along}")
    return "\n".join([*lines, f"        {legend}"])
