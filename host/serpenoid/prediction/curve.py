"""Predicted speed over frequency, for the picture of a comparison."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from ..model.gait import Gait
from ..servos.speed_limit import highest_hz
from .band import SpeedBand, predict
from .comparison import Comparison
from .speeds import draw_samples

POINTS = 12  # points of a curve; a band's ends scatter by more than chords between them are off
MARGINS = 0.6, 1.3  # factors of the lowest and highest frequency that was compared


@lru_cache(maxsize=1)  # a picture and a page draw the same comparison
def speed_curves(compared: Comparison) -> dict[tuple[float, float], list[SpeedBand]]:
    """Return bands at rising frequencies that servos can follow, by amplitude and phase lag."""
    fit, servo = compared.fit, compared.servo
    if fit is None:
        return {}
    samples = draw_samples(fit, servo, compared.amplitude_sigma)
    rates_hz = [row.frequency_hz for row in compared.gaits]
    first_hz, most_hz = MARGINS[0] * min(rates_hz), MARGINS[1] * max(rates_hz)
    curves = {}
    for shape in dict.fromkeys((row.gait.alpha_rad, row.gait.beta_rad) for row in compared.gaits):
        last_hz = min(most_hz, highest_hz(Gait(*shape, math.tau), servo)) if servo else most_hz
        frequency_hz = np.linspace(min(first_hz, 0.6 * last_hz), last_hz, POINTS).tolist()
        curves[shape] = [predict(samples, Gait(*shape, math.tau * hz)) for hz in frequency_hz]
    return curves
