"""Predicted speed as a function of frequency, for the picture of a comparison."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from ..model.gait import Gait
from ..servos.speed_limit import highest_hz
from .band import SpeedBand, predict
from .comparison import Comparison
from .speeds import draw_samples


@lru_cache(maxsize=1)  # the picture and the page of a comparison share it
def speed_curves(compared: Comparison) -> dict[tuple[float, float], list[SpeedBand]]:
    """Return bands at rising frequencies that servos can follow, by amplitude and phase lag."""
    fit, servo = compared.fit, compared.servo
    if fit is None:
        return {}
    samples = draw_samples(fit, servo, compared.amplitude_sigma)
    rates_hz = [row.frequency_hz for row in compared.gaits]
    first_hz, max_hz = 0.6 * min(rates_hz), 1.3 * max(rates_hz)
    curves = {}
    for shape in dict.fromkeys((row.gait.alpha_rad, row.gait.beta_rad) for row in compared.gaits):
        last_hz = min(max_hz, highest_hz(Gait(*shape, math.tau), servo)) if servo else max_hz
        # A band's ends scatter by more than the error of straight lines between 12 points.
        frequency_hz = np.linspace(min(first_hz, 0.6 * last_hz), last_hz, 12).tolist()
        curves[shape] = [predict(samples, Gait(*shape, math.tau * hz)) for hz in frequency_hz]
    return curves
