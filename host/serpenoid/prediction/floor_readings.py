"""Readings that could be taken next on a floor."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..calibration.fitting.posterior import Mode
from ..calibration.fitting.rolling_law import rest, way_m
from ..session.push import WAYS, Push
from ..session.session import Session
from ..session.track import Track
from ..taking.expected import pull_of
from .next_reading import NextReading, Option, next_number

SPEED_M_S, RATE_HZ, RESTED_S = 0.9, 30.0, 0.4
BENDS_RAD = tuple(map(math.radians, (0.0, 20.0, 42.0)))
PUSH_MIN, BEND_MIN = 0.7, 1.5  # what a person takes
_PLACE_M = 0.001  # of a film, where none before it states what a place is off by


def floor_options(session: Session, mode: Mode) -> Iterator[Option]:
    """Yield pushes that could be taken next, seen as those before."""
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
        pushes = _pushes(session, law, posed, filmed)
        minutes = len(pushes) * PUSH_MIN + (0.0 if angle == last else BEND_MIN)
        told = f"pushes, {pose}, at {SPEED_M_S:g} m/s, one there and one back, {how}"
        shown = NextReading("push", times=len(pushes), minutes=minutes, told=told, **posed)
        yield shown, [replace(session, further=(*session.further, *pushes))]


def _pushes(
    session: Session, law: np.ndarray, posed: dict[str, Any], filmed: bool
) -> Sequence[Push]:
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
    return [Push(first + k, way=way, **cells, **posed) for k, way in enumerate(WAYS)]
