"""Every push beside the law that was fitted, for pictures."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..session.session import Session
from .fit import map_estimate
from .parameters import Floats
from .pushes import Pushes
from .rolling_law import rest_point, way_m

POINTS, RESTED_S = 80, 0.2  # points of a drawn law, and how long after its rest it ends


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
    estimate, paths = map_estimate(session), []
    for pushes in estimate.posterior.kinds:
        if not isinstance(pushes, Pushes):
            continue
        laws = pushes.laws(estimate.values)[0]
        pushes_and_tracks = zip(session.kept_pushes, pushes.tracks, laws, strict=True)
        for k, (push, track, law) in enumerate(pushes_and_tracks):
            if k in pushes.linear:
                numbers = np.concatenate([pushes.linear[k].start, law])[None]
                residuals = track.residuals(numbers)[0, : len(track.t_s)]
                residual_m, t_s = -residuals * track.place_sigma_m, track.t_s
                law_m = track.along_m - residual_m
            else:
                c, f = law[:1], law[1:2] - law[2]
                speed = track.rest_speed(c, f)
                stop_s, stop_m = rest_point(speed, c, f)
                residual_m = track.along_m - stop_m
                t_s = np.linspace(0.0, float(stop_s[0]) + RESTED_S, POINTS)
                law_m = way_m(t_s, speed, c, f)
            whose = push.number, push.lambda_rad, push.way
            paths.append(PushPath(*whose, track.t_s, track.along_m, residual_m, t_s, law_m))
    return paths
