"""Measured and fitted paths of all pushes, for pictures."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..session.push import Push
from ..session.session import Session
from .fit import map_estimate
from .parameters import Floats
from .pushes import Pushes


def push_paths(session: Session) -> Iterator[tuple[Push, Floats, Floats, Floats]]:
    """Yield each kept push with its times, s, and its measured and fitted distances, m.

    A push of which only the end is known has a single row. Raises BadInput and NotConverged as fits
    do.
    """
    estimate = map_estimate(session)
    for pushes in estimate.posterior.kinds:
        if not isinstance(pushes, Pushes):
            continue
        laws = pushes.laws(estimate.values)[0]
        parts = zip(session.kept_pushes, pushes.tracks, pushes.linear, laws, strict=True)
        for push, track, linear, law in parts:
            residuals = track.residuals(np.concatenate([linear.start, law])[None])
            law_m = track.along_m + residuals[0, : len(track.t_s)] * track.place_sigma_m
            yield push, track.t_s, track.along_m, law_m
