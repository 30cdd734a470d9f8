"""Predicted speed over frequency, for the picture of a comparison."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from ..base.vectors import Array
from ..calibration.friction_result import FrictionFit
from ..model.gait import Gait
from ..periodic.servo_steady import band
from .comparison import Comparison
from .speeds import draw_samples, speeds

POINTS = 49  # of all curves of a picture: chords between them are 0.1 % off
MARGINS = 0.5, 1.3  # of the lowest and the highest frequency that was compared


@dataclass(frozen=True)
class SpeedCurve:
    """Speed over frequency at one amplitude and phase lag, ideal joints, with friction's band.

    frequency_hz, exact_m_s, low_m_s, high_m_s: (points,).
    """

    alpha_rad: float
    beta_rad: float
    frequency_hz: Array
    exact_m_s: Array
    low_m_s: Array
    high_m_s: Array

    @property
    def shape(self) -> tuple[float, float]:
        """Return amplitude and phase lag."""
        return self.alpha_rad, self.beta_rad


def speed_curves(fit: FrictionFit, compared: Comparison) -> list[SpeedCurve]:
    """Return a curve for each amplitude and phase lag of the compared gaits."""
    shapes = list(dict.fromkeys((gait.alpha_rad, gait.beta_rad) for gait in compared.gaits))
    rates = [gait.frequency_hz for gait in compared.gaits]
    low_hz, high_hz = MARGINS[0] * min(rates), MARGINS[1] * max(rates)
    frequency_hz = np.geomspace(low_hz, high_hz, max(POINTS // len(shapes), 12))
    samples = draw_samples(fit, amplitude_sigma=0.0)
    fitted = np.array([list(fit.whole_snake.values())])
    samples = replace(
        samples,
        whole=np.vstack([fitted, samples.whole]),
        amplitude=np.append(1.0, samples.amplitude),
    )
    curves = []
    for shape in shapes:
        gaits = [Gait(*shape, math.tau * hz) for hz in frequency_hz.tolist()]
        drawn = np.array([speeds(samples, gait).friction_m_s for gait in gaits])
        ends = np.array([band(row[1:]) for row in drawn])
        curves.append(SpeedCurve(*shape, frequency_hz, drawn[:, 0], *ends.T))
    return curves
