"""Motion of a robot that slips sideways, by the slope of the floor or a crooked release.

The robot has no straight link: its links are at +-lambda to its axis, half of them to either side.
While it rolls fast, half of the wheels slip to the left and half to the right, so that dry friction
has no component across the axis and no moment. Viscous friction has both. With speed v along the
axis, w across it, turning rate r, and the floor's pull a across,

    w' = a - c w - r v,    r' = -c r,    v' = -(c_along v + f) + r w,

since the damping of a turn over the moment of inertia equals that of the slip over the mass for n
links along the axis (up to the links' own inertia: 2 % with 8 links, 9 % with 4). When v has fallen
to |w| / tan(lambda), half of the wheels stop slipping. From then on the robot rolls along these
without turning, and is braked like one whose other half is bent by twice lambda.
"""

from __future__ import annotations

import math

import numpy as np

from .parameters import Floats, Integers
from .rolling_law import integral, rolled_m, stop_point

MOMENTS = 200  # equally spaced moments of the motion: its integrals are then right to 1e-5 m
# Standard deviations of how hands let go: of the axis to the push, and of its turning. With less,
# sound sessions are called contradictory. A path too short to tell counts as a straight start.
CROOKED_RAD, TURNING_RAD_S = math.radians(2.0), math.radians(4.0)


def slipped_places(t_s: Floats, chord_rad: float, start: Floats, law: Floats) -> Floats:
    """Return positions (K, 2, T) along a push's chord and to the left of it, m, at times (T,).

    chord_rad: angle of the chord to the line of the floor. start: (K, 6), speed, position along and
    across, angle of the axis to the chord, and slip and turning at the release, in their sigmas.
    law: (K, 8), c and f along the axis on level ground, the floor's pull along its line and to the
    left, the links' angle to the axis, c of the slip, and c and f after the slip has ended.
    """
    speed, x0, y0, axis_rad, crooked, turning = start.T[..., None]
    c, f, pull_along, pull_left, angle_rad, c_across, c_end, f_end = law.T[..., None]

    def pull(heading_rad: Floats) -> tuple[Floats, Floats]:
        """Return the floor's pull ahead and to the left of a heading, m/s^2."""
        cos, sin = np.cos(chord_rad + heading_rad), np.sin(chord_rad + heading_rad)
        return pull_along * cos + pull_left * sin, pull_left * cos - pull_along * sin

    def slowed(first: Floats, braking: Floats, push: Floats) -> Floats:
        """Return the speed from an initial one, viscous braking and an acceleration."""
        grown = np.exp(braking * t)
        return (first + integral(grown * push, t)) / grown

    level = f - pull(axis_rad)[0]
    t = np.minimum(stop_point(speed, c, level)[0], t_s[-1]) * np.linspace(0.0, 1.0, MOMENTS)
    turn = TURNING_RAD_S * turning * np.exp(-c_across * t)
    heading = axis_rad + integral(turn, t)
    v = slowed(speed, c, -level)
    w = slowed(CROOKED_RAD * crooked * speed, c_across, pull(heading)[1] - turn * v)
    v = slowed(speed, c, turn * w - level)
    x = x0 + integral(v * np.cos(heading) - w * np.sin(heading), t)
    y = y0 + integral(v * np.sin(heading) + w * np.cos(heading), t)
    ended = _crossing(np.abs(w) - np.tan(angle_rad) * v)
    end_s = _between(t, ended)
    moment = np.minimum(t_s, end_s) / t[:, 1:2]
    v, w, heading = (_between(part, ended) for part in (v, w, heading))
    direction = heading + np.copysign(angle_rad, w)
    braked = f_end - pull(direction)[0]
    rolled = rolled_m(np.maximum(t_s - end_s, 0.0), np.hypot(v, w), c_end, braked)
    x, y = _between(x, moment), _between(y, moment)
    return np.stack([x + np.cos(direction) * rolled, y + np.sin(direction) * rolled], axis=1)


def _crossing(values: Floats) -> Floats:
    """Return at which moment (K, 1) values (K, M) first pass 0, between two; the last if none."""
    above = values[:, 1:] > 0.0
    first = np.where(above.any(axis=1), above.argmax(axis=1), MOMENTS - 2)[:, None]
    low, high = (np.take_along_axis(values, first + k, axis=1) for k in (0, 1))
    share = np.where(high > 0.0, -low / np.where(high > low, high - low, 1.0), 1.0)
    return first + np.clip(share, 0.0, 1.0)


def _between(values: Floats, moment: Floats) -> Floats:
    """Return values (K, M) at moments (K, T) between two of them."""
    first: Integers = np.clip(moment, 0, MOMENTS - 2).astype(np.intp)
    low, high = (np.take_along_axis(values, first + k, axis=1) for k in (0, 1))
    return low + (moment - first) * (high - low)
