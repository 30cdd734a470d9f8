"""Speeds of a gait for samples of friction, amplitude and servos, and their 95 % band."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..base.vectors import Array
from ..friction.result import FrictionFit, ground_of
from ..model.drives import Servo, ServoKind
from ..model.gait import Gait
from ..model.ground import Ground
from ..model.robot import Robot
from ..periodic.servo_steady import (
    band,
    drawn_servo_speed,
    drawn_servo_speeds,
    ripple_share,
    servo_speed,
)
from ..periodic.steady import drawn_states, steady_gait
from ..servos.catalogue import HOBBY
from ..servos.speed_limit import is_too_fast, too_fast_text

Progress = Callable[[float], object]
AMPLITUDE_SIGMA = 0.03  # Sigma of the ratio of true to commanded amplitude, for all gaits.
SAMPLES = 64


def speed(robot: Robot, ground: Ground, gait: Gait, servo: Servo | None = None) -> float:
    """Return the exact model's speed, m/s, to 1e-3; servo: None for ideal joints."""
    ideal = steady_gait(robot, ground, gait, rtol=1e-3, powers=False)
    return ideal.speed_m_s if servo is None else servo_speed(ideal, servo)


def scaled(gait: Gait, amplitude: float) -> Gait:
    """Return the gait with its amplitude times a factor; the product is at most pi."""
    return replace(gait, alpha_rad=min(gait.alpha_rad * amplitude, math.pi))


@dataclass(frozen=True)
class Samples:
    """N equally likely samples of friction, amplitude and servo.

    fit: the fit; solutions for all samples start from that for its ground. kind: kind of servo;
    None if joints follow the gait. frictions: (N, 4), of the whole snake. amplitude: (N,), ratio of
    the joints' amplitude to the commanded one. servos: N of the kind; empty without a kind.
    """

    fit: FrictionFit
    kind: ServoKind | None
    frictions: Array
    amplitude: Array
    servos: tuple[Servo, ...]


def draw_samples(
    fit: FrictionFit,
    kind: ServoKind | None = None,
    amplitude_sigma: float = AMPLITUDE_SIGMA,
    count: int = SAMPLES,
    seed: int = 2005,
) -> Samples:
    """Return samples of a fit's friction, of the amplitude, and of a kind of servo.

    amplitude_sigma: relative sigma of the amplitude. count: number of samples.
    """
    from scipy.special import ndtri

    quantiles = np.random.default_rng(seed).permutation((np.arange(count) + 0.5) / count)
    amplitude = 1.0 + amplitude_sigma * ndtri(quantiles)
    servos = tuple(kind.draws(count, seed)) if kind else ()
    return Samples(fit, kind, fit.sample_whole(count, seed), amplitude, servos)


def speeds(
    samples: Samples, gait: Gait, commanded: Gait | None = None, fine_count: int = 5
) -> Array:
    """Return the speeds of one gait for each sample, m/s, (3, N).

    First row: only friction differs from sample to sample. Second row: the joints' amplitude too.
    Third row: the servos too, if they can follow. commanded: the commanded gait, if `gait` is how
    the joints moved in a film. The amplitude is then known, and of a servo only the ripple counts.
    fine_count: as of `drawn_servo_speeds`.
    """
    robot, count = samples.fit.robot, len(samples.frictions)
    grounds = [ground_of(robot.links, row) for row in samples.frictions.tolist()]
    moving_gaits = [commanded or scaled(gait, share) for share in samples.amplitude.tolist()]
    draws = list(zip(2 * grounds, [gait] * count + moving_gaits, strict=True))
    states = drawn_states(robot, (samples.fit.ground, gait), draws)
    ideal_m_s = np.array([state.speed_m_s for state in states]).reshape(2, count)
    friction_m_s, joints_m_s = ideal_m_s[[0, 0]] if commanded else ideal_m_s
    if not samples.servos or (not commanded and is_too_fast(gait, samples.kind)):
        return np.array([friction_m_s, joints_m_s, joints_m_s])
    value = ripple_share if commanded else drawn_servo_speed
    moved = drawn_servo_speeds(states[count:], samples.servos, value=value, fine_count=fine_count)
    return np.array([friction_m_s, joints_m_s, joints_m_s * moved if commanded else moved])


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


def speed_band(fit: FrictionFit, gait: Gait, servo: ServoKind | None = HOBBY) -> SpeedBand:
    """Return the speed of one gait with its band.

    servo: the kind of servo; None: ideal joints.
    """
    return predict(draw_samples(fit, servo), gait)
