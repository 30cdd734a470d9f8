"""Predicted speed over frequency, for the picture of a comparison."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ..base.vectors import Array
from ..model.gait import Gait
from ..servos.speed_limit import highest_hz
from .band import predict
from .comparison import Comparison
from .speeds import draw_samples

POINTS = 12  # points of a curve; a band's ends scatter by more than chords between them are off
MARGINS = 0.6, 1.3  # factors of the lowest and highest frequency that was compared


@dataclass(frozen=True)
class SpeedCurve:
    """Speed over frequency at one amplitude and phase lag, with its 95 % band.

    frequency_hz, typical_m_s, low_m_s, high_m_s: (points,), of typical servos, and over samples of
    friction, amplitude and servos; up to highest_hz, beyond which the servos cannot follow.
    """

    alpha_rad: float
    beta_rad: float
    frequency_hz: Array
    typical_m_s: Array
    low_m_s: Array
    high_m_s: Array
    highest_hz: float

    @property
    def shape(self) -> tuple[float, float]:
        """Return amplitude and phase lag."""
        return self.alpha_rad, self.beta_rad


@lru_cache(maxsize=1)  # a picture and a page draw the same comparison
def speed_curves(compared: Comparison) -> list[SpeedCurve]:
    """Return a curve for each amplitude and phase lag of the compared gaits; none without a fit."""
    fit, servo = compared.fit, compared.servo
    if fit is None:
        return []
    samples = draw_samples(fit, servo, compared.amplitude_sigma)
    rates_hz = [gait.frequency_hz for gait in compared.gaits]
    first_hz, most_hz = MARGINS[0] * min(rates_hz), MARGINS[1] * max(rates_hz)
    curves = []
    for shape in dict.fromkeys((gait.alpha_rad, gait.beta_rad) for gait in compared.gaits):
        limit_hz = math.inf if servo is None else highest_hz(Gait(*shape, math.tau), servo)
        last_hz = min(most_hz, limit_hz)
        frequency_hz = np.linspace(min(first_hz, 0.6 * last_hz), last_hz, POINTS)
        gaits = [Gait(*shape, math.tau * hz) for hz in frequency_hz.tolist()]
        bands = [predict(samples, gait) for gait in gaits]
        ends = np.array([[band.speed_m_s, band.low_m_s, band.high_m_s] for band in bands]).T
        curves.append(SpeedCurve(*shape, frequency_hz, ends[0], ends[1], ends[2], limit_hz))
    return curves
