"""The predicted speed of a gait with its 95 % band."""

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
    """The speed of one gait as predicted from a fit, with 95 % intervals.

    speed_m_s: with the typical servo. exact_m_s: with ideal joints.
    low_m_s, high_m_s: over samples of friction, of the joints' amplitude and of the servo.
    low_friction_m_s, high_friction_m_s: over samples of friction alone, with ideal joints.
    low_joints_m_s, high_joints_m_s: over samples of friction and amplitude.
    servo: name of the kind of servo; None for joints that follow the gait.
    filmed: whether the joints move as filmed, so that their amplitude is certain.
    too_fast: a sentence if the gait is too fast for the servos, whose band is then NaN; else "".
    samples_m_s: (3, N), the speeds of the samples, as of `speeds`.
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
        """Return the gait's frequency, Hz."""
        return self.gait.omega_rad_s / math.tau

    def to_dict(self) -> dict[str, Any]:
        """Return values by name for JSON; the band's ends are None if the gait is too fast."""
        hidden = ("gait", "exact_m_s", "samples_m_s", "too_fast", "level_runs", "slope_shares")
        values = {name: value for name, value in vars(self).items() if name not in hidden}
        return values | ({"low_m_s": None, "high_m_s": None} if self.too_fast else {})

    def in_words(self) -> str:
        """Return the speed with its band, or the reason why it has none."""
        if self.too_fast:
            return self.too_fast
        ends = f"{self.low_m_s:.4f} to {self.high_m_s:.4f}"
        joints = ", joints as filmed" if self.filmed else " and joints"
        joints += "" if self.servo is None else f", servos: {self.servo}"
        return f"{self.speed_m_s:.4f} m/s, {ends} (95 %, friction{joints})"


def predict(samples: Samples, gait: Gait, commanded: Gait | None = None) -> SpeedBand:
    """Return a gait's speed by the exact model, with its band over samples.

    commanded: the command, if `gait` is the motion of the joints in a film.
    """
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
) -> SpeedBand:
    """Return the speed of one gait with its band.

    count: number of samples. servo: the kind of servo; None: ideal joints.
    """
    return predict(draw_samples(fit, servo, count=count), gait)
