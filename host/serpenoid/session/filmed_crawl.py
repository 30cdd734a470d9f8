"""A filmed crawl's track, places and joints over time, as the cells of a `video` reading.

Each joint's angle is fitted by a sine of one common rate; the speed is the chord of a cycle over
its time, mean over all cycles that the film holds.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ..base.errors import BadInput
from ..base.sines import basis, fit_sines
from ..model.gait import Gait
from .declaration import Cells

Array = NDArray[np.float64]
LEAST_CYCLES, FEWEST_PICTURES = 1.5, 8
SPEED_SIGMA, GAIN_SIGMA = 0.002, 0.002  # at least: the film's scale, and the chain's fit
_RATE_ERROR = 0.1  # of the rate commanded: how far the joints' own may be from it
_UNEVEN = 0.2  # of the angles' variance: what no sine of one rate explains


def crawl_cells(rows: Array, gait: Gait) -> Cells:
    """Return the cells of a film of a gait but its hash.

    rows: t_s, x_m, y_m, heading_rad and every joint's angle, rad; NaN where it was not seen. gait:
    as commanded. Raises BadInput.
    """
    t, angles = rows[:, 0], rows[:, 4:]
    if np.ptp(t) < LEAST_CYCLES * gait.period_s:
        raise BadInput(
            f"the film shows {np.ptp(t) / gait.period_s:.1f} cycles of the gait; at least "
            f"{LEAST_CYCLES:g} tell its joints"
        )
    omega, sines, sigma = _sines(t, angles, gait)
    amplitude, phase = np.hypot(*sines[1:]), np.arctan2(sines[1], sines[2])
    gains = amplitude / gait.alpha_rad
    turns = np.exp(1j * (phase - gait.beta_rad * np.arange(len(phase))))
    shifts = np.angle(turns / turns.mean())
    speed, scatter = _speed(rows, 2 * math.pi / omega)
    return {
        "alpha_deg": math.degrees(gait.alpha_rad),
        "beta_deg": math.degrees(gait.beta_rad),
        "omega_rad_s": omega,
        "offset_deg": math.degrees(float(sines[0].mean())),
        "speed_m_s": speed,
        "speed_sigma_m_s": math.hypot(scatter, SPEED_SIGMA * speed, 1e-5),
        "gain_sigma": math.hypot(sigma / gait.alpha_rad, GAIN_SIGMA),
        "gains": ",".join(f"{gain:.5f}" for gain in gains),
        "shifts_deg": ",".join(f"{math.degrees(s):.3f}" for s in shifts),
    }


def _sines(t: Array, angles: Array, gait: Gait) -> tuple[float, Array, float]:
    """Return the rate, rad/s, centre, cosine and sine of every joint, and an amplitude's sigma."""
    filmed = ~np.isnan(angles)
    if filmed.sum(axis=0).min() < FEWEST_PICTURES:
        raise BadInput(
            f"a joint was seen in less than {FEWEST_PICTURES} pictures; a session's reading needs "
            "all joints"
        )
    weight = filmed.astype(float)
    omega, sines = fit_sines(t, np.nan_to_num(angles), weight, gait.omega_rad_s, harmonics=1)
    residuals = (basis(t, omega, harmonics=1) @ sines - angles)[filmed]
    mean_square = float(np.mean(residuals**2))
    if abs(omega / gait.omega_rad_s - 1.0) > _RATE_ERROR or mean_square > _UNEVEN * np.var(
        angles[filmed]
    ):
        raise BadInput(
            f"the joints do not swing at {gait.omega_rad_s / (2 * math.pi):.3g} Hz, as was "
            "commanded; is it a film of another gait?"
        )
    return omega, sines, math.sqrt(2 * mean_square / filmed.sum(axis=0).min())


def _speed(rows: Array, period_s: float) -> tuple[float, float]:
    """Return the mean chord of a cycle over its time, m/s, and its standard deviation."""
    t, x, y = rows[:, 0], rows[:, 1], rows[:, 2]
    starts = t <= t[-1] - period_s
    chords = [np.interp(t[starts] + period_s, t, way) - way[starts] for way in (x, y)]
    speeds = np.hypot(*chords) / period_s
    cycles = max(np.ptp(t) / period_s - 1.0, 0.5)
    return float(speeds.mean()), float(speeds.std() / math.sqrt(cycles))
