"""What a camera records of a robot that rolls out or crawls."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..base.vectors import Array
from .floor import Track


@dataclass(frozen=True)
class Camera:
    """A phone on a tripod: about rate_hz pictures a second, at times that it writes down.

    jitter_s: scatter of the true interval between pictures. sigma_m: of a place found in a picture.
    scale: of all lengths, seen over true. missing: share of pictures in which nothing was found.
    sigma_rad: of the heading.
    """

    rate_hz: float = 30.0
    jitter_s: float = 0.002
    sigma_m: float = 0.001
    sigma_rad: float = 0.003
    scale: float = 1.0
    missing: float = 0.0


def film(track: Track, camera: Camera, rng: np.random.Generator) -> Array:
    """Return what a film shows of a push, from the hand's first touch until 0.3 s after it rests.

    Rows t_s, x_m, y_m of the robot's centre, heading_rad; (pictures, 4).
    """
    end = float(track.t_s[-1]) + 0.3
    gaps = 1 / camera.rate_hz + camera.jitter_s * np.clip(rng.normal(size=int(end * 100)), -3, 3)
    t = float(rng.uniform()) / camera.rate_hz + np.cumsum(gaps)
    t = t[(t < end) & (rng.uniform(size=t.size) >= camera.missing)]
    return filmed(t, track, np.empty((len(track.t_s), 0)), camera, rng)


def filmed(
    t_s: Array, track: Track, joints_rad: Array, camera: Camera, rng: np.random.Generator
) -> Array:
    """Return what pictures at some times show: t_s, x_m, y_m, heading_rad and each joint, rad."""
    true = np.column_stack([track.x_m, track.y_m, track.heading_rad, joints_rad])
    rows = np.stack([np.interp(t_s, track.t_s, way) for way in true.T])
    rows[:2] *= camera.scale
    rows[:2] += camera.sigma_m * rng.normal(size=rows[:2].shape)
    rows[2:] += camera.sigma_rad * rng.normal(size=rows[2:].shape)
    return np.column_stack([t_s, *rows])
