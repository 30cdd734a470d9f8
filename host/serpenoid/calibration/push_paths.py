"""Every push beside the law that was fitted, for pictures."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..session.session import Session
from .fitting.rolling_law import rest, way_m
from .fitting.unknowns import Floats
from .floor.block import Pushes
from .session_posterior import mode_of

_POINTS, _RESTED_S = 80, 0.2


@dataclass(frozen=True)
class PushPath:
    """One push: places over time, the law through them, and the distance between, m and s.

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
    """Return the kept pushes of a session with the law as it was fitted.

    Raises BadInput and NotConverged as fits do.
    """
    mode = mode_of(session)
    pushes = [block for block in mode.posterior.blocks if isinstance(block, Pushes)]
    if not pushes:
        return []
    paths = []
    laws = pushes[0].level_laws(mode.values)
    for push, (track, c, f) in zip(session.kept_pushes, laws, strict=True):
        speed, place, _ = track.profiled(c, f)
        stop = float(rest(speed, c, f)[0][0])
        law_t_s = np.linspace(0.0, min(stop + _RESTED_S, 100.0), _POINTS)
        seen_t_s = np.full(1, stop) if track.by == "rest" else track.t_s
        ways = place + way_m(np.concatenate([seen_t_s, law_t_s]), speed, c, f)[0]
        seen, law = ways[:-_POINTS], ways[-_POINTS:]
        whose = push.number, push.lambda_rad, push.way
        paths.append(PushPath(*whose, track.t_s, track.x_m, track.x_m - seen, law_t_s, law))
    return paths
