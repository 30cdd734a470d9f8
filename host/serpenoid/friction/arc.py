"""The way along a path that is nearly straight, from places in a plane that scatter."""

from __future__ import annotations

import numpy as np

from .parameters import Floats

MIN_SCATTERS = 20.0  # of a place: a shorter way has no direction to speak of


def along(x_m: Floats, y_m: Floats, sigma_m: float) -> Floats:
    """Return the way along the path at each place, m: onto the chord, the path's curve added.

    The curve is a parabola through the places, so that their scatter across adds nothing.
    """
    ahead, slope, _ = _curve(x_m, y_m, sigma_m)
    longer = np.polyint(0.5 * np.polymul(slope, slope))
    return ahead + np.polyval(longer, ahead) - np.polyval(longer, ahead[0])


def across(x_m: Floats, y_m: Floats) -> Floats:
    """Return how far each place is to the left of the chord, m."""
    chord_rad = chord_of(x_m, y_m)
    return np.asarray(np.cos(chord_rad) * y_m - np.sin(chord_rad) * x_m)


def turn_rad(x_m: Floats, y_m: Floats) -> float:
    """Return how far the path turns from its first place to its last, rad, + to the left."""
    directions = directions_rad(x_m, y_m, 0.0)
    return float(directions[-1] - directions[0])


def directions_rad(x_m: Floats, y_m: Floats, sigma_m: float) -> Floats:
    """Return the path's direction at each place, rad, in the frame of the places."""
    ahead, slope, chord_rad = _curve(x_m, y_m, sigma_m)
    return np.asarray(chord_rad + np.arctan(np.polyval(slope, ahead)))


def _curve(x_m: Floats, y_m: Floats, sigma_m: float) -> tuple[Floats, Floats, float]:
    """Return places along the chord, the path's slope over them as a polynomial, the chord's angle.

    The chord goes from the first places to the last. The slope is 0 on too short a way.
    """
    eighth = max(1, len(x_m) // 8)
    dx, dy = (float(np.mean(v[-eighth:]) - np.mean(v[:eighth])) for v in (x_m, y_m))
    chord_rad = float(np.arctan2(dy, dx))
    c, s = np.cos(chord_rad), np.sin(chord_rad)
    ahead = c * x_m + s * y_m
    if np.ptp(ahead) < MIN_SCATTERS * sigma_m:
        return ahead, np.zeros(1), chord_rad
    return ahead, np.polyder(np.polyfit(ahead, c * y_m - s * x_m, 2)), chord_rad


def chord_of(x_m: Floats, y_m: Floats) -> float:
    """Return the direction of the chord from the first places to the last, rad."""
    return _curve(x_m, y_m, 0.0)[2]
