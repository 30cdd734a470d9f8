"""A body that rolls out: v' = -(c v + f) while it moves; once it rests it stays.

c is the viscous friction over the mass that is to be stopped, f all dry forces over it. From speed
v0 the way after t is, with z = c t,

    x(t) = v0 t p(z) - f t^2 q(z),    p = (1 - e^-z) / z,    q = (z - 1 + e^-z) / z^2,

until it rests at t_s = (v0 / f) l, l = log(1 + w) / w, w = c v0 / f; afterwards x stays x(t_s) =
(v0^2 / f) (1 - l) / w. Written so, nothing cancels for c near 0. With f below 0 it never rests: the
slope is too steep.
"""

from __future__ import annotations

import numpy as np
from numpy.polynomial.polynomial import polyval

from .parameters import Floats

_SMALL = 0.05  # below it the series are exact to 1e-10


def rest(v0: Floats, c: Floats, f: Floats) -> tuple[Floats, Floats]:
    """Return when a body rests, s, and after what way, m.

    Infinite where f is not above 0; 0, where v0 is not: a fit may try that.
    """
    stops, v0 = f > 0.0, np.maximum(v0, 0.0)
    safe = np.where(stops, f, 1.0)
    w = np.where(stops, c * v0 / safe, 0.0)
    small = np.abs(w) < 1e-3
    far = np.where(small, 1.0, w)
    log = np.log1p(far) / far
    time = v0 / safe * np.where(small, polyval(w, _TIME), log)
    way = v0**2 / safe * np.where(small, polyval(w, _WAY), (1.0 - log) / far)
    return np.where(stops, time, np.inf), np.where(stops, way, np.inf)


def way_m(t: Floats, v0: Floats, c: Floats, f: Floats) -> tuple[Floats, Floats, Floats]:
    """Return the way after t, m, its derivatives (3, K) by v0, c and f, and the speed then, m/s.

    All arguments (K,), v0, c and f also (1,). Before t = 0 it is taken to have rolled at v0.
    """
    end = np.minimum(t, rest(v0, c, f)[0])
    rolled = np.maximum(end, 0.0)
    z = c * rolled
    p, q, by_p, by_q = shapes(z)
    way = v0 * rolled * p - f * rolled**2 * q + v0 * np.minimum(t, 0.0)
    slopes = np.stack(
        [
            rolled * p + np.minimum(t, 0.0),
            v0 * rolled**2 * by_p - f * rolled**3 * by_q,
            -(rolled**2) * q,
        ]
    )
    speed = np.where(t > end, 0.0, v0 * np.exp(-z) - f * rolled * p)
    return way, slopes, speed


def shapes(z: Floats) -> tuple[Floats, Floats, Floats, Floats]:
    """Return p, q and their derivatives by z."""
    small = np.abs(z) < _SMALL
    far = np.where(small, 1.0, z)
    e = np.exp(-far)
    q = np.where(small, polyval(z, _Q), (far - 1.0 + e) / far**2)
    by_q = np.where(small, polyval(z, _BY_Q), (2.0 - far - (far + 2.0) * e) / far**3)
    return 1.0 - z * q, q, -q - z * by_q, by_q


_Q = (1 / 2, -1 / 6, 1 / 24, -1 / 120, 1 / 720, -1 / 5040, 1 / 40320)
_BY_Q = (-1 / 6, 1 / 12, -1 / 40, 1 / 180, -1 / 1008, 1 / 6720, -1 / 51840)
_TIME, _WAY = (1.0, -1 / 2, 1 / 3, -1 / 4, 1 / 5), (1 / 2, -1 / 3, 1 / 4, -1 / 5)
