"""Readings that could be taken next on a floor."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..calibration.fitting.posterior import Mode
from ..calibration.fitting.rolling_law import rest, slide_s, way_m
from ..calibration.kinds.coast import WAYS, Coast
from ..calibration.kinds.slide import Slide
from ..calibration.kinds.tracks import Track
from ..calibration.session import Session
from ..calibration.taking.expected import pull_of
from .next_reading import NextReading, Option, next_number

SPEED_M_S, RATE_HZ, RESTED_S = 0.9, 30.0, 0.4
BENDS_RAD = tuple(map(math.radians, (0.0, 20.0, 42.0)))
TIMES_BREAKAWAY = (1.4, 2.0, 3.0)
PUSH_MIN, BEND_MIN, SLIDE_MIN = 0.7, 1.5, 1.0  # what a person takes
STEEPEST = math.sin(math.radians(30.0))
_PLACE_M = 0.001  # of a film, where none before it states what a place is off by


def floor_options(session: Session, mode: Mode) -> Iterator[Option]:
    """Yield pushes, seen as those before, and slides that could be taken next."""
    filmed = any(push.track is not None for push in session.kept_pushes)
    how = "filmed" if filmed else "by tape and watch"
    setup, last = session.setup, math.nan
    if session.kept_pushes:
        last = session.kept_pushes[-1].lambda_rad
    for bend in BENDS_RAD:
        angle = last if abs(last - bend) < math.radians(3.5) else bend
        pose = f"bent {math.degrees(angle):.3g}°" if angle else "straight"
        drag, dry_n = pull_of(setup, mode.x[:4].tolist(), angle)
        law = np.array([drag, dry_n]) * setup.procedure.gravity_m_s2 / setup.weight_n
        posed = {"lambda_rad": angle, "bend": setup.procedure.bend}
        pushes, slides = _pushes(session, law, posed, filmed), list(_slides(session, law, posed))
        inclines = ", ".join(f"{math.degrees(s.incline_rad):.1f}" for s in slides)
        ways = f"at {SPEED_M_S:g} m/s, one there and one back, {how}"
        first_min = 0.0 if angle == last else BEND_MIN
        for kind, readings, each_min, told in (
            ("coast", pushes, PUSH_MIN, f"pushes, {pose}, {ways}"),
            ("slide", slides, SLIDE_MIN, f"slides, {pose}, over 1 m of board at {inclines}°"),
        ):
            if readings:
                times, minutes = len(readings), len(readings) * each_min + first_min
                shown = NextReading(kind, times=times, minutes=minutes, told=told, **posed)
                yield shown, [replace(session, further=(*session.further, *readings))]


def _pushes(
    session: Session, law: np.ndarray, posed: dict[str, Any], filmed: bool
) -> Sequence[Coast]:
    """Return a push each way, as they would be seen; law: c and f of v' = -(c v + f)."""
    start = np.array([[SPEED_M_S], [law[0]], [law[1]]])
    rest_s, rest_m = (float(part[0]) for part in rest(*start))
    cells: dict[str, Any] = {"distance_m": rest_m, "duration_s": rest_s}
    if filmed:
        known = [p.distance_sigma_m for p in session.kept_pushes if p.track and p.distance_sigma_m]
        t = np.arange(0.0, rest_s + RESTED_S, 1 / RATE_HZ)
        x = way_m(t, *np.broadcast_to(start, (3, len(t))))[0]
        track = Track.of(("t_s", "x_m", "y_m"), np.stack([t, x, 0 * t], axis=1))
        sigma_m = float(np.median(known)) if known else _PLACE_M
        cells = {"by": "film", "track": track, "distance_sigma_m": sigma_m}
    cells["place"] = session.kept_pushes[-1].place if session.kept_pushes else ""
    first = next_number(session)
    return [Coast(first + k, way=way, **cells, **posed) for k, way in enumerate(WAYS)]


def _slides(session: Session, law: np.ndarray, posed: dict[str, Any]) -> Iterator[Slide]:
    """Yield slides down a metre at some times the least incline."""
    c, f = law[:, None]
    gravity = session.setup.procedure.gravity_m_s2
    for k, times in enumerate(TIMES_BREAKAWAY):
        sine = times * float(f[0]) / gravity
        if sine > STEEPEST:
            return
        incline = math.asin(sine) + session.zero.value_rad
        time_s = float(slide_s(np.ones(1), c, (times - 1.0) * f)[0])
        number = next_number(session) + k
        yield Slide(number, incline_rad=incline, distance_m=1.0, duration_s=time_s, **posed)
