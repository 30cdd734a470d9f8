"""The one 95 % band of a predicted speed."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..base.vectors import Array
from ..friction.result import FrictionFit
from ..model.drives import ServoKind
from ..model.gait import Gait
from ..periodic.servo_steady import band
from ..servos.catalogue import HOBBY
from ..servos.speed_limit import too_fast_text
from .speeds import SAMPLES, Samples, draw_samples, speed, speeds


@dataclass(frozen=True, eq=False)
class SpeedBand:
    """Hold what a fit predicts of one gait: the speed, and the 95 % interval about it.

    speed_m_s: with the typical servo; exact_m_s: of ideal joints. low_m_s, high_m_s: over samples
    of the frictions that the readings allow, each with joints whose amplitude is off by
    AMPLITUDE_SIGMA and with a servo of its own. low_friction_m_s, high_friction_m_s: the narrower
    one, of friction alone and ideal joints; low_joints_m_s, high_joints_m_s: that with the
    amplitude's doubt. servo: the kind of servo; None: joints that follow the gait. filmed: the
    joints are as a film showed them, so that their amplitude is certain. too_fast: the sentence
    that the gait is too fast for the servos, or ""; low_m_s and high_m_s are then NaN.
    samples_m_s: (3, N), as of `speeds`.
    """

    gait: Gait
    speed_m_s: float
    low_m_s: float
    high_m_s: float
    low_friction_m_s: float
    high_friction_m_s: float
    low_joints_m_s: float
    high_joints_m_s: float
    servo: str | None
    filmed: bool
    too_fast: str
    exact_m_s: float
    samples_m_s: Array

    @property
    def frequency_hz(self) -> float:
        """Return the gait's frequency."""
        return self.gait.omega_rad_s / math.tau

    def to_dict(self) -> dict[str, Any]:
        """Return plain values; None for the ends of a band where the gait is too fast."""
        hidden = ("gait", "exact_m_s", "samples_m_s", "too_fast", "level_runs", "slope_shares")
        values = {name: value for name, value in vars(self).items() if name not in hidden}
        return values | ({"low_m_s": None, "high_m_s": None} if self.too_fast else {})

    def in_words(self) -> str:
        """Return the speed with its band, or why it has none."""
        if self.too_fast:
            return self.too_fast
        ends = f"{self.low_m_s:.4f} to {self.high_m_s:.4f}"
        joints = ", joints as filmed" if self.filmed else " and joints"
        joints += "" if self.servo is None else f", servos: {self.servo}"
        return f"{self.speed_m_s:.4f} m/s, {ends} (95 %, friction{joints})"


def predict(samples: Samples, gait: Gait, commanded: Gait | None = None) -> SpeedBand:
    """Return a gait's speed by the exact model, with the band of samples; commanded: as there."""
    fit, kind = samples.fit, samples.kind
    samples_m_s = speeds(samples, gait, commanded)
    friction, joints, ends = map(band, samples_m_s)
    exact_m_s = speed(fit.robot, fit.ground, gait)
    typical_m_s = exact_m_s
    if commanded:
        typical_m_s *= float(np.median(samples_m_s[2] / np.maximum(samples_m_s[1], 1e-9)))
    elif kind:
        typical_m_s = speed(fit.robot, fit.ground, gait, kind.servo)
    too_fast = "" if commanded else too_fast_text(gait, kind)
    if too_fast:
        ends = math.nan, math.nan
    servo = kind and kind.name, commanded is not None, too_fast
    values = typical_m_s, *ends, *friction, *joints, *servo, exact_m_s, samples_m_s
    return SpeedBand(gait, *values)


def speed_band(
    fit: FrictionFit,
    gait: Gait,
    count: int = SAMPLES,
    servo: ServoKind | None = HOBBY,
    commanded: Gait | None = None,
) -> SpeedBand:
    """Return the band of one gait; servo: any hobby servo unless given, None: ideal joints."""
    return predict(draw_samples(fit, servo, count=count), gait, commanded)
