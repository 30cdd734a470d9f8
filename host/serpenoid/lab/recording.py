"""A virtual camera: noisy tracks of a robot that rolls to a stop or crawls."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..base.vectors import Array
from .floor import Track


@dataclass(frozen=True)
class Camera:
    """A phone on a tripod, which records frames with their times.

    rate_hz: mean frame rate. jitter_s: standard deviation of the interval between frames. sigma_m,
    sigma_rad: standard deviations of a position and of an angle in a frame. scale: ratio of filmed
    to true lengths. missing: share of the frames in which the robot is not found.
    """

    rate_hz: float = 30.0
    jitter_s: float = 0.002
    sigma_m: float = 0.001
    sigma_rad: float = 0.003
    scale: float = 1.0
    missing: float = 0.0


def film(track: Track, camera: Camera, rng: np.random.Generator) -> Array:
    """Return a film's track of a push, (frames, 4): t_s, x_m and y_m of the centre, heading_rad.

    It begins when the hand first touches the robot, and ends 0.3 s after the robot has stopped.
    """
    end = float(track.t_s[-1]) + 0.3
    gaps = 1 / camera.rate_hz + camera.jitter_s * np.clip(rng.normal(size=int(end * 100)), -3, 3)
    t = float(rng.uniform()) / camera.rate_hz + np.cumsum(gaps)
    t = t[(t < end) & (rng.uniform(size=t.size) >= camera.missing)]
    return filmed(t, track, np.empty((len(track.t_s), 0)), camera, rng)


def filmed(
    t_s: Array, track: Track, joints_rad: Array, camera: Camera, rng: np.random.Generator
) -> Array:
    """Return the track in frames at t_s (T,): rows of t_s, x_m, y_m, heading_rad, joint angles."""
    true = np.column_stack([track.x_m, track.y_m, track.heading_rad, joints_rad])
    rows = np.stack([np.interp(t_s, track.t_s, column) for column in true.T])
    rows[:2] *= camera.scale
    rows[:2] += camera.sigma_m * rng.normal(size=rows[:2].shape)
    rows[2:] += camera.sigma_rad * rng.normal(size=rows[2:].shape)
    return np.column_stack([t_s, *rows])
