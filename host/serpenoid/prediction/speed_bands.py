"""How well speeds are known: parts of their bands, and how these change with friction.

Of a speed, the sampled frictions give what goes with friction linearly (a regression of sampled
speeds, not a tangent); a covariance says what is left of that.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..base.errors import BadInput
from ..base.rows import two_digits
from ..calibration.fitting.unknowns import Floats
from ..calibration.friction_result import FrictionFit
from ..calibration.speeds import AMPLITUDE_SIGMA, Progress, speed
from ..model.drives import ServoKind
from ..model.gait import Gait
from .speed_samples import sample_speeds

_Z95 = 1.959964
SERVO_LEFT = 0.5  # of the servos' doubt, after a bench test of one joint


@dataclass(frozen=True)
class SpeedBands:
    """Mean speeds of gaits (G,), their change by friction (G, P), and halves of 95 % bands.

    The halves are over the speed, each the mean over the gaits. whole: with friction, amplitude and
    servos in doubt. joints: with ideal servos. friction: with ideal joints.
    """

    gaits: tuple[Gait, ...]
    speed_m_s: Floats
    slope: Floats
    friction: float
    joints: float
    whole: float

    def by_friction(self, covariance: Floats, ran: Sequence[Sequence[float]] = ()) -> float:
        """Return the band of friction alone, to first order, with such a covariance.

        ran: per gait, the standard deviations of its runs' speeds. Each tells its own speed, but
        for the joints' amplitude, which runs of one gait share.
        """
        of = self.slope.shape[1]
        friction = covariance[:of, :of]
        for slope, v, sigmas in zip(self.slope, self.speed_m_s, ran, strict=False):
            if len(sigmas):
                noise = 1.0 / np.sum(np.asarray(sigmas) ** -2.0) + (AMPLITUDE_SIGMA * v) ** 2
                gain = friction @ slope
                friction = friction - np.outer(gain, gain) / (slope @ gain + noise)
        sigma = np.sqrt(np.einsum("gi,ij,gj->g", self.slope, friction, self.slope))
        return float(np.mean(_Z95 * sigma / self.speed_m_s))

    def after(self, ratio: float) -> float:
        """Return the whole band once friction's part has shrunk by a ratio."""
        return math.sqrt(max(self.whole**2 - self.friction**2, 0.0) + (ratio * self.friction) ** 2)

    @property
    def servos(self) -> float:
        """Return the servos' part, 0 where the joints follow the gait."""
        return math.sqrt(max(self.whole**2 - self.joints**2, 0.0))

    @property
    def servo_measured(self) -> float:
        """Return the whole band after a bench test of one joint."""
        return math.hypot(self.joints, SERVO_LEFT * self.servos)

    def servo_note(self, servo: ServoKind | None, band_after_best: float) -> str:
        """Return what to say where a servo is what to measure; "" where a reading tells more."""
        if servo is None or servo.drawn or self.servo_measured >= band_after_best:
            return ""
        servos, friction, measured, reading = (
            f"±{two_digits(100 * part)} %"
            for part in (self.servos, self.friction, self.servo_measured, band_after_best)
        )
        return (
            f"Measure a servo next. Servos ({servo.name}) leave {servos} of the speed, friction "
            f"{friction}. A bench test of one joint (`serpenoid servo --test`) leaves {measured} "
            f"in all, the best reading {reading}."
        )


def speed_bands(
    fit: FrictionFit,
    gaits: Sequence[Gait],
    servo: ServoKind | None,
    count: int,
    progress: Progress | None = None,
) -> SpeedBands:
    """Sample speeds as `compare` does; raises BadInput for a gait that goes nowhere."""
    drawn = sample_speeds(
        fit,
        gaits,
        amplitude_sigma=AMPLITUDE_SIGMA,
        servo=servo,
        count=count,
        progress=progress,
    )
    mean = drawn.friction_m_s.mean(axis=0)
    if mean.min() <= 0.0:
        raise BadInput("one of the gaits does not move at all; choose a larger amplitude")
    centred = drawn.whole - drawn.whole.mean(axis=0)
    # a little of the fit's own covariance keeps frictions known all but exactly in their place
    ridge = 1e-6 * count * np.diag(np.diag(fit.covariance))
    slope = np.linalg.solve(centred.T @ centred + ridge, centred.T @ (drawn.friction_m_s - mean))
    best = np.maximum([speed(fit.robot, fit.ground, gait) for gait in gaits], 1e-9)
    halves = np.mean(np.ptp(drawn.ends_m_s, axis=2).T / 2 / best, axis=1)
    return SpeedBands(tuple(gaits), mean, slope.T, *halves.tolist())
