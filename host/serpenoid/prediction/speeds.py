"""Speeds of a gait over samples of what a fit, the joints and the servos allow."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..base.vectors import Array
from ..friction.result import FrictionFit, ground_of
from ..model.drives import Servo, ServoKind
from ..model.gait import Gait
from ..model.ground import Ground
from ..model.robot import Robot
from ..periodic.neighbours import drawn_states
from ..periodic.servo_steady import drawn_servo_speeds, ripple_share, servo_speed
from ..periodic.steady import steady_gait

Progress = Callable[[float], object]
AMPLITUDE_SIGMA = 0.03  # of the joints' true over commanded amplitude, common to all gaits
SAMPLES = 64


def speed(robot: Robot, ground: Ground, gait: Gait, servo: Servo | None = None) -> float:
    """Return the exact model's speed to 1e-3 of itself, m/s; servo: what moves the joints."""
    ideal = steady_gait(robot, ground, gait, rtol=1e-3, powers=False)
    return ideal.speed_m_s if servo is None else servo_speed(ideal, servo)


def scaled(gait: Gait, amplitude: float) -> Gait:
    """Return the gait as joints run it that reach this share of their amplitude, at most pi."""
    return replace(gait, alpha_rad=min(gait.alpha_rad * amplitude, math.pi))


@dataclass(frozen=True)
class Samples:
    """N samples of what moves a robot, each as likely as any other.

    ground: the fitted one, from whose periodic states those of the samples are sought. whole:
    (N, P), frictions of the whole snake. amplitude: (N,), of the joints over the commanded one.
    """

    robot: Robot
    ground: Ground
    whole: Array
    amplitude: Array


@dataclass(frozen=True)
class GaitSpeeds:
    """Speeds of one gait, m/s, (N,): of sampled frictions, with the amplitudes, with the servos."""

    friction_m_s: Array
    joints_m_s: Array
    all_m_s: Array


def draw_samples(
    fit: FrictionFit,
    amplitude_sigma: float = AMPLITUDE_SIGMA,
    count: int = SAMPLES,
    seed: int = 2005,
) -> Samples:
    """Return samples of a fit's friction, and of an amplitude with this standard deviation."""
    from scipy.special import ndtri

    evenly = np.random.default_rng(seed).permutation((np.arange(count) + 0.5) / count)
    amplitude = 1.0 + amplitude_sigma * ndtri(evenly)
    return Samples(fit.robot, fit.ground, fit.sample_whole(count, seed), amplitude)


def draw_servos(servo: ServoKind | None, count: int = SAMPLES, seed: int = 2005) -> list[Servo]:
    """Return a servo of this kind for each sample; none where joints follow the gait."""
    return [] if servo is None else list(servo.draws(count, seed))


def speeds(
    samples: Samples, gait: Gait, servos: Sequence[Servo] = (), commanded: Gait | None = None
) -> GaitSpeeds:
    """Return the speeds of one gait for each sample.

    servos: one for each sample; none: the joints follow the gait. commanded: what the robot was
    told, where a film showed that its joints do `gait`. Their amplitude is then certain, and of a
    servo only the ripple counts.
    """
    grounds = [ground_of(samples.robot.links, row) for row in samples.whole.tolist()]
    reached = [gait if commanded else scaled(gait, a) for a in samples.amplitude.tolist()]
    asked = [commanded or made for made in reached]
    count = len(grounds)
    draws = list(zip(3 * grounds, [gait] * count + reached + asked, strict=True))
    once = list(dict.fromkeys(draws))
    found = drawn_states(samples.robot, (samples.ground, gait), once)
    state_of = dict(zip(once, found, strict=True))
    states = [state_of[draw] for draw in draws]
    ideal = np.array([state.speed_m_s for state in states])
    friction, joints = ideal[:count], ideal[count : 2 * count]
    if not servos:
        moved = joints
    elif commanded:
        moved = joints * drawn_servo_speeds(states[2 * count :], servos, value=ripple_share)
    else:
        moved = drawn_servo_speeds(states[2 * count :], servos)
    return GaitSpeeds(friction, joints, moved)
