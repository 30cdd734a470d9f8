"""Readings that could be taken next on a floor, and the covariance that each would leave."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..fitting.bends import Bends
from ..fitting.posterior import Mode
from ..fitting.rolling_law import slide_s, stop_s, way_m
from ..fitting.unknowns import Floats
from ..floor.block import Rolling
from ..floor.notes import check_floor
from ..kinds.coast import Coast
from ..kinds.slide import Slide
from ..kinds.station import bent_share
from ..kinds.tracks import Track
from ..session import Session
from ..session_posterior import information_at, linear_covariance, mode_of

SPEED_M_S, RATE_HZ, RESTED_S = 0.9, 30.0, 0.4
BENDS_RAD = tuple(map(math.radians, (0.0, 20.0, 42.0)))
TIMES_BREAKAWAY = (1.4, 2.0, 3.0)
PUSH_MIN, BEND_MIN, SLIDE_MIN = 0.7, 1.5, 1.0  # what a person takes
STEEPEST = math.sin(math.radians(30.0))


@dataclass(frozen=True)
class Candidate:
    """A few readings: what they are in words, minutes they take, and the covariance after them."""

    kind: str
    told: str
    lambda_rad: float
    count: int
    minutes: float
    covariance: Floats


def candidates(session: Session, by_film: bool) -> tuple[Floats, list[Candidate]]:
    """Return the frictions' covariance now, and what could be taken next. Raises BadInput.

    by_film: whether pushes are filmed; else they are timed to rest, by tape and watch.
    """
    mode = mode_of(session)
    check_floor(session, mode)
    now = linear_covariance(session, mode)
    last = session.kept_pushes[-1].lambda_rad if session.kept_pushes else math.nan
    out = []
    for bend in BENDS_RAD:
        for slide in (False, True):
            angle = last if abs(last - bend) < math.radians(3.5) else bend
            made = list(
                _slides(session, mode, angle) if slide else _pushes(session, mode, angle, by_film)
            )
            if not made:
                continue
            grown = replace(session, further=(*session.further, *made))
            minutes = len(made) * (SLIDE_MIN if slide else PUSH_MIN)
            minutes += 0.0 if angle == last else BEND_MIN
            after = linear_covariance(grown, _after(grown, mode))
            kind = "slide" if slide else "coast"
            out.append(
                Candidate(kind, _told(made, angle, by_film), angle, len(made), minutes, after)
            )
    return now, out


def _after(grown: Session, mode: Mode) -> Mode:
    """Return what is known with more readings, at the unknowns as they are."""
    whole = information_at(grown, mode.x[: mode.posterior.frictions]).posterior
    x = np.array([mode.values.get(name, np.zeros(1))[0] for name in whole.names])
    return whole.near(x).at(x)


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
    speed, first = np.array([SPEED_M_S]), _next_number(session)
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
            _next_number(session) + k,
            angle,
            math.asin(sine) + session.zero.value_rad,
            1.0,
            float(time[0]),
            bend=session.setup.procedure.bend,
        )


def _next_number(session: Session) -> int:
    return 1 + max((r.number for _, r in session.numbered), default=0)


def _told(made: Sequence[Coast | Slide], angle: float, by_film: bool) -> str:
    pose = f"bent {math.degrees(angle):.3g}°" if angle else "straight"
    if isinstance(made[0], Slide):
        inclines = ", ".join(f"{math.degrees(s.incline_rad):.1f}" for s in made)  # type: ignore[union-attr]
        return f"slides, {pose}, over 1 m of board at {inclines}°"
    how = "filmed" if by_film else "by tape and watch"
    return f"pushes, {pose}, at {SPEED_M_S:g} m/s, one there and one back, {how}"
