"""Closed-form solution of v' = -(c v + f), the motion of a body that rolls to a stop.

c, 1/s, is the viscous friction over the moving mass; f, m/s^2, is the sum of all constant forces
against the motion, over the same mass. From the initial speed v0 the body travels, with z = c t,

    x(t) = v0 t p(z) - f t^2 q(z),    p = (1 - e^-z) / z,    q = (z - 1 + e^-z) / z^2,

until it stops at t_s = (v0 / f) l, with l = log(1 + w) / w and w = c v0 / f. From then on x stays
at x(t_s) = (v0^2 / f) (1 - l) / w. In this form no digits cancel when c is near 0. If f is not
positive, the slope is too steep and the body never stops.
"""

from __future__ import annotations

import numpy as np
from numpy.polynomial.polynomial import polyval

from .parameters import Floats


def stop_point(v0: Floats, c: Floats, f: Floats) -> tuple[Floats, Floats]:
    """Return the time, s, and the distance, m, at which a body stops.

    Both are infinite where f <= 0, and 0 where v0 <= 0, which a fit may try. The arguments and
    results have one shape.
    """
    stops, v0 = f > 0.0, np.maximum(v0, 0.0)
    safe_f = np.where(stops, f, 1.0)
    w = np.where(stops, c * v0 / safe_f, 0.0)
    smallest = 1e-3  # below it the series are exact to 1e-10
    large = np.where(np.abs(w) < smallest, smallest, w)
    log = np.where(
        large == w, np.log1p(large) / large, polyval(w, (1, -1 / 2, 1 / 3, -1 / 4, 1 / 5))
    )
    share = np.where(large == w, (1.0 - log) / large, polyval(w, (1 / 2, -1 / 3, 1 / 4, -1 / 5)))
    time_s, distance_m = v0 / safe_f * log, v0**2 / safe_f * share
    return np.where(stops, time_s, np.inf), np.where(stops, distance_m, np.inf)


def rolled_m(t_s: Floats, v0: Floats, c: Floats, f: Floats) -> Floats:
    """Return the distance travelled until times t_s, m; before t = 0 the speed is v0.

    All arguments broadcast together.
    """
    rolling_s = np.clip(t_s, 0.0, stop_point(v0, c, f)[0])
    p, q = coefficients(c * rolling_s)
    return v0 * rolling_s * p - f * rolling_s**2 * q + v0 * np.minimum(t_s, 0.0)


def coefficients(z: Floats) -> tuple[Floats, Floats]:
    """Return the coefficients p and q of x(t), in the shape of z."""
    smallest = 0.05  # below it the series is exact to 1e-10
    large = np.where(np.abs(z) < smallest, smallest, z)
    series = polyval(z, (1 / 2, -1 / 6, 1 / 24, -1 / 120, 1 / 720, -1 / 5040, 1 / 40320))
    q = np.where(large == z, (large - 1.0 + np.exp(-large)) / large**2, series)
    return 1.0 - z * q, q


def integral(rate: Floats, t_s: Floats) -> Floats:
    """Return the integrals (K, T) of rates (K, T) from the first of the times t_s, (T,) or (K, T).

    They are computed by the trapezoidal rule.
    """
    steps = 0.5 * np.diff(t_s) * (rate[:, 1:] + rate[:, :-1])
    start = np.zeros((len(rate), 1))
    return np.concatenate([start, np.cumsum(steps, axis=1)], axis=1)
