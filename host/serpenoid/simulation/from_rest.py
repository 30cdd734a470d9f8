"""Which motion a gait settles to from rest, and whether it has another stable one beside it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from itertools import islice
from time import monotonic

import numpy as np

from ..base.errors import Diverged
from ..base.vectors import Array
from ..model.link_state import LinkState
from ..periodic.steady import FromRest, Motion, Steady
from .scene import Scene, exact_scene
from .simulate import simulate, start_state, with_motion

# Of the distance to the reported motion: what a settled motion may still change from run to run,
# and what one may where the time is over.
_REPEATS, _NEARLY_REPEATS = 1e-3, 0.02
_LONGEST_S = 2.0  # waiting
_CYCLES = 10, 100, 6000  # cycles: fewest, most on dry ground, most on viscous ground
# On viscous ground 43 of 3200 random robots had two stable motions, in bent gaits: with cn / ct up
# to 0.33, and ct over mass and rate of the gait up to 0.02. These are two and three times that.
_LOW_GRIP, _LOW_DAMPING = 0.6, 0.06
_SPIN = 0.5  # share of the gait's rate: turning rate of a start that may lead to the other motion
_PUSH = 0.3  # share of body length times rate: speed of such a start


def from_rest(state: Steady) -> FromRest | None:
    """Return where a start from rest leads, and the other stable motion if there is one.

    Runs follow the motion until it agrees with the reported state, or repeats where it does not.
    Where viscous ground may have two motions, runs from other starts look for the second. None:
    after two seconds of waiting it did neither; it may only settle slowly.
    """
    gait, ground, until = state.gait, state.ground, monotonic() + _LONGEST_S
    if ground.smooth and not _may_have_two_motions(state):
        return FromRest(True, None)
    cycles_limit = _CYCLES[2] if ground.smooth else _CYCLES[1]
    cycles = math.ceil(min(max(state.settling_time_s / gait.period_s, _CYCLES[0]), cycles_limit))
    scene = Scene(state.robot, ground, gait, dt_s=gait.period_s, duration_s=cycles * gait.period_s)
    scene = exact_scene(scene, 1e-5)
    body_m = state.robot.body_length_m
    reported = np.array([state.turn_rad_per_cycle, state.chord_m_s * gait.period_s / body_m])
    for k, start in enumerate(islice(_starts(scene), None if ground.smooth else 1)):
        motion = _settled(replace(scene, start=start), reported, until)
        if k == 0 and motion is None:
            return None
        if motion is not None and not _same(motion, reported):
            turn_rad, lengths = motion.tolist()
            return FromRest(k > 0, Motion(turn_rad, lengths * body_m / gait.period_s))
    return FromRest(True, None)


def two_motions_text(state: Steady) -> str:
    """Return the two stable motions of a gait and which one a start from rest reaches, or ""."""
    if state.from_rest is None or state.from_rest.other is None:
        return ""
    second, reported = (
        f"turns {math.degrees(motion.turn_rad_per_cycle):.3g} deg and goes "
        f"{motion.chord_m_s * state.gait.period_s:.3g} m a cycle"
        for motion in (state.from_rest.other, state)
    )
    if state.from_rest.reaches_reported:
        return (
            "this gait has two stable motions: from rest the robot ends in the reported one, which "
            f"{reported}; the other {second}"
        )
    return (
        f"this gait has two stable motions: from rest the robot ends in the one that {second}; the "
        f"reported one {reported}"
    )


def _may_have_two_motions(state: Steady) -> bool:
    """Return whether viscous friction is so low, and grips so little, that bends may have two."""
    ground = state.ground
    damping = ground.ct_forward / (state.robot.link_mass_kg * state.gait.omega_rad_s)
    low = ground.cn < _LOW_GRIP * ground.ct_forward and damping < _LOW_DAMPING
    return state.gait.offset_rad != 0 and low


def _starts(scene: Scene) -> Iterator[LinkState]:
    """Yield the state at rest, then such that turn, or move along the tail, either way."""
    rest_state, rate = start_state(scene), scene.gait.omega_rad_s
    for spin, push in ((0, 0), (_SPIN, 0), (-_SPIN, 0), (0, _PUSH), (0, -_PUSH)):
        ahead_m_s = push * scene.robot.body_length_m * rate
        yield with_motion(rest_state, ahead_m_s, 0.0, spin * rate)


def _settled(scene: Scene, reported: Array, until: float) -> Array | None:
    """Return the motion to which a scene settles, or the first one like the reported one.

    A motion is what a cycle turns, rad, and travels, body lengths.
    """
    motion, previous, change = None, None, math.inf  # over the distance to the reported motion
    while monotonic() < until and not change < _REPEATS:
        try:
            run = simulate(scene)
        except Diverged:
            return None
        travel_m = np.hypot(*np.diff(run.centre_m[-5:], axis=0).T).mean()
        turn_rad = (run.theta_rad[-1, 0] - run.theta_rad[-5, 0]) / 4
        previous, motion = motion, np.array([turn_rad, travel_m / scene.robot.body_length_m])
        if _same(motion, reported):
            return motion
        if previous is not None:
            change = math.dist(motion, previous) / math.dist(motion, reported)
        scene = replace(scene, start=run.state())
    return motion if change < _NEARLY_REPEATS else None


def _same(motion: Array, reported: Array) -> bool:
    # They differ by less than 1 % of what a cycle turns and travels, and of 0.1 more.
    return math.dist(motion, reported) < 0.01 * (0.1 + math.hypot(*reported))
