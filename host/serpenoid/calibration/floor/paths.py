"""Every push beside the law that was fitted, for pictures."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..fitting.data import FitData, Floats
from ..fitting.rolling_law import stop_s, way_m
from ..session import Session
from .data import FloorData
from .minimum import least

_POINTS, _RESTED_S = 80, 0.2


@dataclass(frozen=True)
class PushPath:
    """One push: places over time, the law through them, and what is left, m and s.

    Of a push that is known by its rest alone: that one place.
    """

    number: int
    lambda_rad: float
    way: str
    t_s: Floats
    way_m: Floats
    residual_m: Floats
    law_t_s: Floats
    law_m: Floats


def push_paths(session: Session) -> list[PushPath]:
    """Return the kept pushes of a session with the law as it was fitted; raises BadInput."""
    floor = FloorData.of(session)
    problem, found, _ = least(floor, FitData.of(session) if session.kept else None)
    c, f, _, _ = problem.motion(found.x)
    v0, x0 = found.x[problem.layout.speeds], found.x[problem.layout.starts]
    predicted = problem.predicted(found.x)[0]
    out = []
    for k, push in enumerate(session.kept_pushes):
        mine = np.flatnonzero(floor.tracks.push == k)
        if len(mine):
            t, x, told = floor.tracks.t_s[mine], floor.tracks.x_m[mine], predicted[mine]
        else:
            rest = floor.rests.push == k
            t, x = floor.rests.t_s[rest], floor.rests.x_m[rest]
            told = predicted[problem.rows[1]][rest]
        stop = float(stop_s(v0[k : k + 1], c[k : k + 1], f[k : k + 1])[0][0])
        line = np.linspace(0.0, min(stop + _RESTED_S, 100.0), _POINTS)
        one = np.ones(_POINTS)
        law = x0[k] + way_m(line, v0[k] * one, c[k] * one, f[k] * one)[0]
        out.append(PushPath(push.number, push.lambda_rad, push.way, t, x, x - told, line, law))
    return out
