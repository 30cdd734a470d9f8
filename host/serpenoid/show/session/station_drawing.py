"""The stations so far as an SVG's parts: belt speed against incline, each bend with its line."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from ...calibration.session import Session
from ...calibration.taking.expected import line_of, of_series, series_of

CURVE = 24  # points of a line


def stations_svg(session: Session) -> str:
    """Return the parts of a picture of 640 by 340; none before the first station.

    A line has the 95 % band that its stations leave.
    """
    plan = session.setup.procedure
    bends = [(series, of_series(session, series)) for series in series_of(plan)]
    if plan.on == "floor" or not any(stations for _, stations in bends):
        return ""
    points = [
        [(math.asin(r.balance_sine(plan.gravity_m_s2)), r.slip_speed_m_s) for r in stations]
        for _, stations in bends
    ]
    inclines, speeds = np.array([point for part in points for point in part]).T
    low, high = np.degrees(inclines.min()) - 0.2, np.degrees(inclines.max()) + 0.2
    top = 1.12 * speeds.max()

    def places(incline_rad: ArrayLike, speed_m_s: ArrayLike) -> np.ndarray:
        x = 66 + 562 * (np.degrees(incline_rad) - low) / (high - low)
        y = 296 - 244 * np.clip(np.divide(speed_m_s, top), 0, 1)
        return np.column_stack([x, y]).round(1)

    drawn = [
        '<path stroke="var(--line)" fill="none" d="M66 52V296H628"/>'
        '<text x="8" y="20">belt past the robot (m/s) against incline</text>'
    ]
    for k, (incline, speed) in enumerate(
        zip(np.linspace(low, high, 4), np.linspace(0, top, 4), strict=True)
    ):
        x, y = places(np.radians(incline), speed)[0]
        drawn.append(
            f'<text x="{x}" y="322" text-anchor="{"end" if k == 3 else "middle"}">{incline:.1f}°'
            f'</text><text x="60" y="{y + 5}" text-anchor="end">{speed:.2f}</text>'
        )
    for k, ((series, stations), part) in enumerate(zip(bends, points, strict=True)):
        colour, line = f"var(--j{k % 7})", line_of(session, series)
        if line is not None:
            ends = [r.incline_rad for r in stations]
            wide = 0.1 * np.ptp(ends)
            every = np.linspace(min(ends) - wide, max(ends) + wide, CURVE)
            law, sigma = np.transpose([line.through(sine) for sine in np.sin(every)])
            band = np.vstack(
                [places(every, law + 1.96 * sigma), places(every, law - 1.96 * sigma)[::-1]]
            )
            drawn.append(
                f'<polygon points="{_text(band)}" fill="{colour}" fill-opacity="0.18"/>'
                f'<polyline points="{_text(places(every, law))}" stroke="{colour}" '
                'stroke-width="2.5" fill="none"/>'
            )
        spots = places(*np.transpose(part)) if part else []
        drawn += [f'<circle cx="{x}" cy="{y}" r="5" fill="{colour}"/>' for x, y in spots]
        drawn += [
            f'<text x="{min(x - 8, 600)}" y="{y - 10}" text-anchor="end" style="fill:{colour}">'
            f"{series.name}</text>"
            for x, y in spots[-1:]
        ]
    return "".join(drawn)


def _text(places: np.ndarray) -> str:
    return " ".join(map(str, places.ravel()))
