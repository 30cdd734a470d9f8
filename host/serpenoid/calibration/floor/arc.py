"""The way along a path that is nearly straight, from places in a plane that scatter."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
LEAST = 20.0  # scatters of a place: a shorter way has no direction to speak of


def along(x_m: Floats, y_m: Floats, sigma_m: float) -> Floats:
    """Return the way along the path at each place, m: onto the chord, the path's curve added.

    The curve is a parabola through the places, so that their scatter across adds nothing.
    """
    ahead, across = turned(x_m, y_m)
    if np.ptp(ahead) < LEAST * sigma_m:
        return ahead
    slope = np.polyder(np.polyfit(ahead, across, 2))
    longer = np.polyint(0.5 * np.polymul(slope, slope))
    return ahead + np.polyval(longer, ahead) - np.polyval(longer, ahead[0])


def turned(x_m: Floats, y_m: Floats) -> tuple[Floats, Floats]:
    """Return the places in a frame whose first axis points from the first to the last of them."""
    few = max(1, len(x_m) // 8)
    dx, dy = (float(np.mean(v[-few:]) - np.mean(v[:few])) for v in (x_m, y_m))
    far = np.hypot(dx, dy)
    c, s = (dx / far, dy / far) if far > 0.0 else (1.0, 0.0)
    return c * x_m + s * y_m, c * y_m - s * x_m


def turn_rad(x_m: Floats, y_m: Floats) -> float:
    """Return how far the path turns from its first place to its last, rad, + to the left."""
    ahead, across = turned(x_m, y_m)
    slope = np.polyder(np.polyfit(ahead, across, 2))
    ends = np.arctan(np.polyval(slope, ahead[[0, -1]]))
    return float(ends[1] - ends[0])


def directions_rad(x_m: Floats, y_m: Floats, sigma_m: float) -> Floats:
    """Return the path's direction at each place, rad, in the frame of the places."""
    ahead, across = turned(x_m, y_m)
    few = max(1, len(x_m) // 8)
    dx, dy = (float(np.mean(v[-few:]) - np.mean(v[:few])) for v in (x_m, y_m))
    chord = np.full_like(ahead, np.arctan2(dy, dx))
    if np.ptp(ahead) < LEAST * sigma_m:
        return chord
    slope = np.polyder(np.polyfit(ahead, across, 2))
    return np.asarray(chord + np.arctan(np.polyval(slope, ahead)))
