"""The way along a path that is nearly straight, from places in a plane that scatter."""

from __future__ import annotations

import numpy as np

from .track import Floats

MIN_SCATTERS = 20.0  # shortest way, in the scatter of a place, that has a direction


def chord_places(x_m: Floats, y_m: Floats) -> tuple[Floats, Floats, float]:
    """Return places along the chord and to the left of it, m, and the chord's direction, rad.

    The chord goes from the first eighth of the places to the last.
    """
    eighth = max(1, len(x_m) // 8)
    dx, dy = (float(np.mean(v[-eighth:]) - np.mean(v[:eighth])) for v in (x_m, y_m))
    chord_rad = float(np.arctan2(dy, dx))
    c, s = np.cos(chord_rad), np.sin(chord_rad)
    return c * x_m + s * y_m, c * y_m - s * x_m, chord_rad


def curved_path(along_m: Floats, left_m: Floats, sigma_m: float) -> tuple[Floats, Floats]:
    """Return the way along the path at each place, m, and its direction to the chord, rad.

    along_m, left_m: places on the chord. The path is a parabola through them, so that their scatter
    across adds nothing to the way; on too short a way it is the chord.
    """
    if np.ptp(along_m) < MIN_SCATTERS * sigma_m:
        return along_m, np.zeros_like(along_m)
    slope = np.polyder(np.polyfit(along_m, left_m, 2))
    longer_m = np.polyval(np.polyint(0.5 * np.polymul(slope, slope)), along_m)
    return along_m + longer_m - longer_m[0], np.arctan(np.polyval(slope, along_m))
