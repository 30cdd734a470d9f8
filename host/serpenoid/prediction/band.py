"""The one 95 % band of a predicted speed."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from ..friction.result import FrictionFit
from ..model.drives import ServoKind
from ..model.gait import Gait
from ..periodic.servo_steady import band
from ..servos.catalogue import HOBBY
from ..servos.speed_limit import too_fast_text
from .speeds import SAMPLES, draw_samples, draw_servos, speed, speeds


@dataclass(frozen=True)
class SpeedBand:
    """Hold what a fit predicts of one gait: the speed, and the 95 % interval about it.

    low_m_s, high_m_s: over samples of the frictions that the readings allow, each with joints whose
    amplitude is off by AMPLITUDE_SIGMA and with a servo of its own. low_friction_m_s,
    high_friction_m_s: the narrower one, of friction alone and ideal joints; low_joints_m_s,
    high_joints_m_s: that with the amplitude's doubt. servo: the kind of servo; None: joints that
    follow the gait. filmed: the joints are as a film showed them, so that their amplitude is
    certain. too_fast: the sentence that the gait is too fast for the servos, or ""; low_m_s and
    high_m_s are then NaN.
    """

    speed_m_s: float
    low_m_s: float
    high_m_s: float
    low_friction_m_s: float
    high_friction_m_s: float
    low_joints_m_s: float
    high_joints_m_s: float
    servo: str | None = None
    filmed: bool = False
    too_fast: str = ""

    def to_dict(self) -> dict[str, Any]:
        """Return plain values; None for the ends of a band where the gait is too fast."""
        values = asdict(self)
        return values | ({"low_m_s": None, "high_m_s": None} if values.pop("too_fast") else {})

    def in_words(self) -> str:
        """Return the speed with its band, or why it has none."""
        if self.too_fast:
            return self.too_fast
        ends = f"{self.low_m_s:.4f} to {self.high_m_s:.4f}"
        joints = ", joints as filmed" if self.filmed else " and joints"
        joints += "" if self.servo is None else f", servos: {self.servo}"
        return f"{self.speed_m_s:.4f} m/s, {ends} (95 %, friction{joints})"


def speed_band(
    fit: FrictionFit,
    gait: Gait,
    count: int = SAMPLES,
    servo: ServoKind | None = HOBBY,
    commanded: Gait | None = None,
) -> SpeedBand:
    """Predict one gait's speed by the exact model, with the band that fit and joints leave it.

    servo: the kind that moves the joints, any hobby servo unless given; None: they follow the gait.
    commanded: what the robot is told, where a film showed that its joints do `gait`, as for
    `speeds`.
    """
    too_fast = "" if commanded else too_fast_text(gait, servo)
    servos = [] if too_fast else draw_servos(servo, count)
    drawn = speeds(draw_samples(fit, count=count), gait, servos, commanded)
    friction, joints, both = map(band, (drawn.friction_m_s, drawn.joints_m_s, drawn.all_m_s))
    if commanded:
        share = float(np.median(drawn.all_m_s / np.maximum(drawn.joints_m_s, 1e-9)))
        best = share * speed(fit.robot, fit.ground, gait)
    else:
        best = speed(fit.robot, fit.ground, gait, servo and servo.servo)
    ends = (math.nan, math.nan) if too_fast else both
    kind = servo and servo.name
    return SpeedBand(best, *ends, *friction, *joints, kind, commanded is not None, too_fast)
