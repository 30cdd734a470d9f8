"""Speeds of a gait over the frictions that a fit allows, and over what the joints may be off by."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass, field, replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..model.drives import Servo, ServoKind
from ..model.gait import Gait
from ..model.ground import Ground
from ..model.robot import Robot
from ..periodic.drawn_states import Draw, drawn_speeds, drawn_states
from ..periodic.servo_steady import (
    band,
    cannot_run,
    drawn_ripple_shares,
    drawn_servo_speeds,
    servo_speed,
)
from ..periodic.steady import steady_gait
from ..servos.catalogue import HOBBY
from .friction_result import FrictionFit

Array = NDArray[np.float64]
Progress = Callable[[int], None]
MODEL_SIGMA = 0.01  # of a predicted speed: joints' centres that are off, wheels that turn
AMPLITUDE_SIGMA = 0.03  # of the joints' true over commanded amplitude, common to all gaits


def in_threads(
    work: Callable[[Any], Any], items: Iterable[Any], progress: Progress | None = None
) -> list[Any]:
    """Return what each item gives, by as many threads as the machine has cores.

    The core computes without Python's lock. progress: called with 1 after each.
    """
    found = []
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        for one in pool.map(work, items):
            found.append(one)
            if progress is not None:
                progress(1)
    return found


def speed(robot: Robot, ground: Ground, gait: Gait, servo: Servo | None = None) -> float:
    """Return the exact model's speed to 1e-3 of itself, m/s; servo: what moves the joints."""
    ideal = steady_gait(robot, ground, gait, rtol=1e-3, powers=False)
    return ideal.speed_m_s if servo is None else servo_speed(ideal, servo)


@lru_cache(maxsize=256)
def _driven(
    robot: Robot, near: Draw, draws: tuple[Draw, ...], servos: tuple[Servo, ...]
) -> tuple[Array, Array]:
    """Return draws' speeds with ideal joints and with servos, m/s; several commands ask twice."""
    ideal = drawn_states(robot, near, draws)
    return np.array([state.speed_m_s for state in ideal]), drawn_servo_speeds(ideal, servos)


@dataclass(frozen=True)
class SpeedBand:
    """Hold what a fit predicts of one gait: the speed, and the 95 % interval about it.

    This is the one band of every predicted speed: draws of the frictions that the readings allow,
    each with joints whose amplitude is off by AMPLITUDE_SIGMA and with a servo of its own, and the
    draws' quantiles by `band`. low_friction_m_s, high_friction_m_s: the narrower one, of friction
    alone and ideal joints; low_joints_m_s, high_joints_m_s: that with the amplitude's doubt. servo:
    the kind of servo; None: joints that follow the gait. filmed: the joints are as a film showed
    them, so that their amplitude is in no doubt. cannot_run: in words that most servos cannot run
    the gait, so that low_m_s and high_m_s mean little; or "".
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
    cannot_run: str = ""

    def to_dict(self) -> dict[str, Any]:
        """Return plain values; None for the ends of a band that means little."""
        values = asdict(self)
        return values | ({"low_m_s": None, "high_m_s": None} if values.pop("cannot_run") else {})

    def in_words(self) -> str:
        """Return the speed with its band, or why it has none."""
        if self.cannot_run:
            return self.cannot_run
        ends = f"{self.low_m_s:.4f} to {self.high_m_s:.4f}"
        joints = ", joints as filmed" if self.filmed else " and joints"
        joints += "" if self.servo is None else f", servos: {self.servo}"
        return f"{self.speed_m_s:.4f} m/s, {ends} (95 %, friction{joints})"


def speed_band(
    fit: FrictionFit,
    gait: Gait,
    count: int = 64,
    amplitude_sigma: float = AMPLITUDE_SIGMA,
    servo: ServoKind | None = HOBBY,
    commanded: Gait | None = None,
) -> SpeedBand:
    """Predict one gait's speed by the exact model, with the band that fit and joints leave it.

    servo: the kind that moves the joints, any hobby servo unless given; None: they follow the gait.
    commanded: what the robot is told, where a film showed that its joints do `gait`. Then their
    amplitude is in no doubt, and of a servo only the ripple counts.
    """
    seen = {} if commanded is None else {gait: commanded}
    drawn = sample_speeds(
        fit, [gait], amplitude_sigma=amplitude_sigma, servo=servo, seen=seen, count=count
    )
    each = drawn.both_m_s, drawn.friction_m_s, drawn.joints_m_s
    ends = [end for speeds in each for end in band(speeds[:, 0])]
    if commanded is None:
        best = likeliest_speed(fit, gait, servo)
    else:
        best = speed(fit.robot, fit.ground, gait) * float(np.median(drawn.shares))
    filmed = commanded is not None
    words = "" if filmed else cannot_run(gait, servo)
    return SpeedBand(best, *ends, servo=servo and servo.name, filmed=filmed, cannot_run=words)


def likeliest_speed(fit: FrictionFit, gait: Gait, servo: ServoKind | None) -> float:
    """Return the speed that a fit holds for likeliest, m/s, by the typical servo of a kind.

    Where crawls told the joints' amplitude and servos, those count.
    """
    if fit.with_crawls:
        gait = scaled(gait, fit.nuisances["joint_amplitude"].value)
    if servo is not None and fit.servos is not None and fit.servos.kind == servo.name:
        return speed(fit.robot, fit.ground, gait, fit.servos.drawn[fit.servos.best])
    return speed(fit.robot, fit.ground, gait, servo and servo.servo)


def scaled(gait: Gait, amplitude: float) -> Gait:
    """Return the gait as joints run it that reach this share of their amplitude, at most pi."""
    return replace(gait, alpha_rad=min(gait.alpha_rad * amplitude, math.pi))


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
    whole, grounds = fit.sample_whole(count, seed), fit.sample(count, seed)
    servos = [] if servo is None else fit.sample_servos(servo, count, seed)
    amplitudes = drawn_amplitudes(fit, amplitude_sigma, count, seed)
    seen = seen or {}

    def of(gait: Gait) -> tuple[Array, Array, Array]:
        near = (fit.ground, gait)
        alone = drawn_speeds(fit.robot, near, [(g, gait) for g in grounds])
        if servo is None and (not amplitude_sigma or gait in seen):
            return alone, alone, alone
        if gait in seen:
            asked = seen[gait]
            states = drawn_states(fit.robot, (fit.ground, asked), [(g, asked) for g in grounds])
            return alone, alone, alone * drawn_ripple_shares(states, servos)
        draws = [(g, scaled(gait, a)) for g, a in zip(grounds, amplitudes.tolist(), strict=True)]
        if servo is None:
            joints = drawn_speeds(fit.robot, near, draws)
            return alone, joints, joints
        return alone, *_driven(fit.robot, near, tuple(draws), tuple(servos))

    found = zip(*in_threads(of, gaits, progress), strict=True)
    alone, joints, both = (np.array(part, dtype=float).T for part in found)
    if fit.with_crawls and amplitude_sigma:  # else the amplitude's doubt is far larger
        left = 1.0 + MODEL_SIGMA * np.random.default_rng(seed).normal(size=joints.shape)
        joints, both = joints * left, both * left
    return SpeedSamples(tuple(gaits), whole, alone, joints, both, seen=seen)


def drawn_amplitudes(fit: FrictionFit, sigma: float, count: int, seed: int = 2005) -> Array:
    """Return draws of the joints' amplitude over the commanded one: the fit's own, if crawls told.

    sigma: else its standard deviation; 0: it is in no doubt, whatever crawls told.
    """
    from scipy.special import ndtri

    told = fit.sample_amplitudes(count, seed) if sigma else None
    if told is not None:
        return told
    evenly = np.random.default_rng(seed).permutation((np.arange(count) + 0.5) / count)
    return 1.0 + sigma * ndtri(evenly)
