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

SERIES_LIMIT = 0.05  # largest c t whose series are exact to 1e-10
REST_SERIES_LIMIT = 1e-3  # largest w whose series are exact to 1e-10
SERIES_OF_Q = (1 / 2, -1 / 6, 1 / 24, -1 / 120, 1 / 720, -1 / 5040, 1 / 40320)
SERIES_OF_TIME, SERIES_OF_WAY = (1.0, -1 / 2, 1 / 3, -1 / 4, 1 / 5), (1 / 2, -1 / 3, 1 / 4, -1 / 5)


def rest_point(v0: Floats, c: Floats, f: Floats) -> tuple[Floats, Floats]:
    """Return when a body rests, s, and after what way, m.

    Infinite where f is not above 0; 0, where v0 is not: a fit may try that.
    """
    stops, v0 = f > 0.0, np.maximum(v0, 0.0)
    safe = np.where(stops, f, 1.0)
    w = np.where(stops, c * v0 / safe, 0.0)
    large = np.where(np.abs(w) < REST_SERIES_LIMIT, REST_SERIES_LIMIT, w)
    log = np.where(large == w, np.log1p(large) / large, polyval(w, SERIES_OF_TIME))
    share = np.where(large == w, (1.0 - log) / large, polyval(w, SERIES_OF_WAY))
    time, way = v0 / safe * log, v0**2 / safe * share
    return np.where(stops, time, np.inf), np.where(stops, way, np.inf)


def way_m(t_s: Floats, v0: Floats, c: Floats, f: Floats) -> Floats:
    """Return the way after a time, m; before t = 0 it is taken to have rolled at v0.

    All arguments (K,), v0, c and f also (1,).
    """
    rolled = np.clip(t_s, 0.0, rest_point(v0, c, f)[0])
    p, q = shapes(c * rolled)
    return v0 * rolled * p - f * rolled**2 * q + v0 * np.minimum(t_s, 0.0)


def shapes(z: Floats) -> tuple[Floats, Floats]:
    """Return p and q."""
    small = np.abs(z) < SERIES_LIMIT
    large = np.where(small, 1.0, z)
    q = np.where(small, polyval(z, SERIES_OF_Q), (large - 1.0 + np.exp(-large)) / large**2)
    return 1.0 - z * q, q


def integral(rate: Floats, t_s: Floats) -> Floats:
    """Return the integrals (K, T) of rates since the first time, by the trapezoidal rule."""
    steps = 0.5 * np.diff(t_s) * (rate[:, 1:] + rate[:, :-1])
    return np.concatenate([np.zeros((len(rate), 1)), np.cumsum(steps, axis=1)], axis=1)
