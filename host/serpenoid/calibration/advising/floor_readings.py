"""Readings that could be taken next on a floor."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from ..fitting.bends import Bends
from ..fitting.posterior import Mode
from ..fitting.rolling_law import slide_s, stop_s, way_m
from ..floor.block import Rolling
from ..kinds.coast import Coast
from ..kinds.slide import Slide
from ..kinds.station import bent_share
from ..kinds.tracks import Track
from ..session import Session
from .next_reading import NextReading, Option, next_number

SPEED_M_S, RATE_HZ, RESTED_S = 0.9, 30.0, 0.4
BENDS_RAD = tuple(map(math.radians, (0.0, 20.0, 42.0)))
TIMES_BREAKAWAY = (1.4, 2.0, 3.0)
PUSH_MIN, BEND_MIN, SLIDE_MIN = 0.7, 1.5, 1.0  # what a person takes
STEEPEST = math.sin(math.radians(30.0))


def floor_options(session: Session, mode: Mode) -> Iterator[Option]:
    """Yield pushes, seen as those before, and slides that could be taken next."""
    by_film = any(push.track is not None for push in session.kept_pushes)
    last = session.kept_pushes[-1].lambda_rad if session.kept_pushes else math.nan
    for bend in BENDS_RAD:
        angle = last if abs(last - bend) < math.radians(3.5) else bend
        pushes, slides = _pushes(session, mode, angle, by_film), _slides(session, mode, angle)
        for kind, made, each_min in (
            ("coast", tuple(pushes), PUSH_MIN),
            ("slide", tuple(slides), SLIDE_MIN),
        ):
            if made:
                shown = NextReading(
                    kind,
                    times=len(made),
                    lambda_rad=angle,
                    bend=session.setup.procedure.bend,
                    minutes=len(made) * each_min + (0.0 if angle == last else BEND_MIN),
                    told=_told(made, angle, by_film),
                )
                yield shown, [replace(session, further=(*session.further, *made))]


def _pose(session: Session, mode: Mode, angle: float) -> tuple[float, float]:
    """Return c and f of a pose on level ground, as the fit has it."""
    bend = session.setup.procedure.bend
    share = bent_share(bend, session.setup.robot.links) if angle else 0.0
    none, nothing = np.array([-1], dtype=np.intp), np.empty(0)
    bends = Bends(np.array([angle]), np.array([share]), none, nothing, nothing)
    c, f, _ = Rolling.of(session).motion(mode.values, bends, np.zeros(1, dtype=bool))
    return float(c[0, 0]), float(f[0, 0])


def _pushes(session: Session, mode: Mode, angle: float, by_film: bool) -> Iterator[Coast]:
    """Yield a push each way, as they would be seen."""
    c, f = (np.array([v]) for v in _pose(session, mode, angle))
    speed, first = np.array([SPEED_M_S]), next_number(session)
    stop = float(stop_s(speed, c, f)[0][0])
    places = [p.place for p in session.kept_pushes]
    known = [p.distance_sigma_m for p in session.kept_pushes if p.track and p.distance_sigma_m]
    common = {
        "lambda_rad": angle,
        "place": places[-1] if places else "",
        "bend": session.setup.procedure.bend,
    }
    for k, way in enumerate(("there", "back")):
        if by_film:
            t = np.arange(0.0, stop + RESTED_S, 1 / RATE_HZ)
            one = np.ones_like(t)
            x = way_m(t, SPEED_M_S * one, c * one, f * one)[0]
            track = Track.of(("t_s", "x_m", "y_m"), np.stack([t, x, 0 * t], axis=1))
            sigma_m = float(np.median(known)) if known else 0.001
            yield Coast(
                first + k, way=way, by="film", track=track, distance_sigma_m=sigma_m, **common
            )
        else:
            far = float(way_m(np.array([stop]), speed, c, f)[0][0])
            yield Coast(first + k, way=way, distance_m=far, duration_s=stop, **common)


def _slides(session: Session, mode: Mode, angle: float) -> Iterator[Slide]:
    """Yield slides down a metre at some times the least incline."""
    c, f = _pose(session, mode, angle)
    gravity = session.setup.procedure.gravity_m_s2
    for k, times in enumerate(TIMES_BREAKAWAY):
        sine = times * f / gravity
        if sine > STEEPEST:
            return
        time = slide_s(np.ones(1), np.array([c]), np.array([(times - 1.0) * f]))
        yield Slide(
            next_number(session) + k,
            angle,
            math.asin(sine) + session.zero.value_rad,
            1.0,
            float(time[0]),
            bend=session.setup.procedure.bend,
        )


def _told(made: Sequence[Coast | Slide], angle: float, by_film: bool) -> str:
    pose = f"bent {math.degrees(angle):.3g}°" if angle else "straight"
    if isinstance(made[0], Slide):
        inclines = ", ".join(f"{math.degrees(s.incline_rad):.1f}" for s in made)  # type: ignore[union-attr]
        return f"slides, {pose}, over 1 m of board at {inclines}°"
    how = "filmed" if by_film else "by tape and watch"
    return f"pushes, {pose}, at {SPEED_M_S:g} m/s, one there and one back, {how}"
