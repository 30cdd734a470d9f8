"""Speeds of a gait over the frictions that a fit allows, and over what the joints may be off by."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from ..calibration.friction_result import FrictionFit
from ..calibration.speeds import (
    AMPLITUDE_SIGMA,
    MODEL_SIGMA,
    Array,
    Progress,
    SpeedModel,
    scaled,
    speed,
)
from ..model.drives import ServoKind
from ..model.gait import Gait
from ..periodic.servo_steady import band
from ..servos.catalogue import HOBBY
from ..servos.speed_limit import too_fast_text


@dataclass(frozen=True)
class SpeedBand:
    """Hold what a fit predicts of one gait: the speed, and the 95 % interval about it.

    This is the one band of every predicted speed: draws of the frictions that the readings allow,
    each with joints whose amplitude is off by AMPLITUDE_SIGMA and with a servo of its own, and the
    draws' quantiles by `band`. low_friction_m_s, high_friction_m_s: the narrower one, of friction
    alone and ideal joints; low_joints_m_s, high_joints_m_s: that with the amplitude's doubt. servo:
    the kind of servo; None: joints that follow the gait. filmed: the joints are as a film showed
    them, so that their amplitude is in no doubt. too_fast: the sentence that the gait is too fast
    for the servos, or ""; low_m_s and high_m_s are then NaN.
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
    count: int = 64,
    servo: ServoKind | None = HOBBY,
    commanded: Gait | None = None,
) -> SpeedBand:
    """Predict one gait's speed by the exact model, with the band that fit and joints leave it.

    servo: the kind that moves the joints, any hobby servo unless given; None: they follow the gait.
    commanded: what the robot is told, where a film showed that its joints do `gait`. Then their
    amplitude is in no doubt, and of a servo only the ripple counts.
    """
    filmed, named = commanded is not None, servo and servo.name
    seen = {gait: commanded} if commanded else {}
    too_fast = "" if filmed else too_fast_text(gait, servo)
    moved_by = None if too_fast else servo
    drawn = sample_speeds(
        fit, [gait], amplitude_sigma=AMPLITUDE_SIGMA, servo=moved_by, seen=seen, count=count
    )
    ends = drawn.ends_m_s[0][[2, 0, 1]].ravel().tolist()
    if too_fast:
        ends[:2] = math.nan, math.nan
    best = (
        speed(fit.robot, fit.ground, gait) * float(np.median(drawn.shares))
        if filmed
        else likeliest_speed(fit, gait, servo)
    )
    return SpeedBand(best, *ends, servo=named, filmed=filmed, too_fast=too_fast)


def likeliest_speed(fit: FrictionFit, gait: Gait, servo: ServoKind | None) -> float:
    """Return the speed that a fit holds for likeliest, m/s, by the typical servo of a kind.

    Where crawls told the joints' amplitude and servos, those count.
    """
    if fit.with_crawls:
        gait = scaled(gait, fit.nuisances["joint_amplitude"].value)
    if servo is not None and fit.servos is not None and fit.servos.kind == servo.name:
        return speed(fit.robot, fit.ground, gait, fit.servos.drawn[fit.servos.best])
    return speed(fit.robot, fit.ground, gait, servo and servo.servo)


@dataclass(frozen=True)
class SpeedSamples:
    """Speeds of some gaits, (samples, gaits), the same draw in each row.

    friction_m_s: over the fit's frictions, joints as commanded. joints_m_s: with each draw's own
    amplitude besides. both_m_s: with its own servo, too. whole: (samples, 4), the frictions, whole
    snake. seen: gaits as films showed the joints, and as commanded: no amplitude is in doubt there.
    """

    gaits: tuple[Gait, ...]
    whole: Array
    friction_m_s: Array
    joints_m_s: Array
    both_m_s: Array
    seen: Mapping[Gait, Gait] = field(default_factory=dict)

    def some(self, index: Sequence[int]) -> SpeedSamples:
        """Return the draws of some of the gaits."""
        columns = {
            name: getattr(self, name)[:, index]
            for name in ("friction_m_s", "joints_m_s", "both_m_s")
        }
        return replace(self, gaits=tuple(self.gaits[j] for j in index), **columns)

    @cached_property
    def ends_m_s(self) -> Array:
        """Return the ends of 95 % bands of friction, with joints, with servos: (gaits, 3, 2)."""
        parts = self.friction_m_s, self.joints_m_s, self.both_m_s
        return np.array([[band(of_gait) for of_gait in part.T] for part in parts]).swapaxes(0, 1)

    @property
    def shares(self) -> Array:
        """Return what each draw's servo leaves of its speeds, (samples, gaits)."""
        return self.both_m_s / np.maximum(self.joints_m_s, 1e-9)


def sample_speeds(
    fit: FrictionFit,
    gaits: Sequence[Gait],
    *,
    amplitude_sigma: float = 0.0,
    servo: ServoKind | None = None,
    seen: Mapping[Gait, Gait] | None = None,
    count: int = 64,
    seed: int = 2005,
    progress: Progress | None = None,
) -> SpeedSamples:
    """Draw speeds; amplitude_sigma: of the joints' true over commanded amplitude, common to all.

    Where crawls told the amplitude and the servos, the fit's own draws of them count instead, and
    each speed may be off by what the model leaves out.
    servo: the kind that moves the joints, one for each friction; None: they follow the gait. seen:
    gaits as films showed the joints, and as commanded; only the ripple of a servo counts there.

    progress is called with the gaits done.
    """
    whole, seen = fit.sample_whole(count, seed), seen or {}
    servos = [] if servo is None else fit.sample_servos(servo, count, seed)
    amplitudes = drawn_amplitudes(fit, amplitude_sigma, count, seed)
    speeds = []
    for gait in gaits:
        model = SpeedModel(fit.robot, fit.ground, (gait,), (seen.get(gait),))
        friction = model.ideal(whole, np.ones(count))
        if servos:
            joints, both = model.driven(whole, amplitudes, servos)
        else:
            joints = both = model.ideal(whole, amplitudes) if amplitude_sigma else friction
        speeds.append((friction, joints, both))
        if progress is not None:
            progress(1)
    friction, joints, both = (np.hstack(part) for part in zip(*speeds, strict=True))
    if fit.with_crawls and amplitude_sigma:  # else the amplitude's doubt is far larger
        model_error = 1.0 + MODEL_SIGMA * np.random.default_rng(seed).normal(size=joints.shape)
        joints, both = joints * model_error, both * model_error
    return SpeedSamples(tuple(gaits), whole, friction, joints, both, seen=seen)


def drawn_amplitudes(fit: FrictionFit, sigma: float, count: int, seed: int = 2005) -> Array:
    """Return draws of the joints' amplitude over the commanded one: the fit's own, if crawls told.

    sigma: else its standard deviation; 0: it is in no doubt, whatever crawls told.
    """
    from scipy.special import ndtri

    fitted = fit.sample_amplitudes(count, seed) if sigma else None
    if fitted is not None:
        return fitted
    evenly = np.random.default_rng(seed).permutation((np.arange(count) + 0.5) / count)
    return 1.0 + sigma * ndtri(evenly)
