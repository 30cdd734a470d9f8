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
from .simulate import simulate, start_state


def from_rest(state: Steady) -> FromRest | None:
    """Return where a start from rest leads, and the other stable motion if there is one.

    Runs follow the motion until it agrees with the reported state, or repeats where it does not.
    Where viscous ground may have two motions, runs from other starts look for the second. None:
    after two seconds of waiting it did neither; it may only settle slowly.
    """
    gait, ground = state.gait, state.ground
    if ground.smooth and not _may_have_two_motions(state):
        return FromRest(True, None)
    cycles_limit = 6000 if ground.smooth else 100
    cycles = math.ceil(np.clip(state.settling_time_s / gait.period_s, 10, cycles_limit))
    scene = Scene(state.robot, ground, gait, dt_s=gait.period_s, duration_s=cycles * gait.period_s)
    scene = exact_scene(scene, 1e-5)
    body_m, until = state.robot.body_length_m, monotonic() + 2.0
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
    start = state.from_rest
    if start is None or start.other is None:
        return ""
    second, reported = (
        f"turns {math.degrees(motion.turn_rad_per_cycle):.3g} deg and goes "
        f"{motion.chord_m_s * state.gait.period_s:.3g} m a cycle"
        for motion in (start.other, state)
    )
    return (
        f"this gait has two stable motions: the reported one {reported}; the other {second}; from "
        f"rest the robot ends in the {'reported' if start.reaches_reported else 'other'} one"
    )


def _may_have_two_motions(state: Steady) -> bool:
    """Return whether viscous friction is so low, and grips so little, that bends may have two.

    Of 3200 random robots 43 had two stable motions, in bent gaits: with cn / ct up to 0.33, and ct
    over mass and rate of the gait up to 0.02. The limits are two and three times that.
    """
    ground, ct = state.ground, state.ground.ct_forward
    low = ct < 0.06 * state.robot.link_mass_kg * state.gait.omega_rad_s
    return state.gait.offset_rad != 0 and ground.cn < 0.6 * ct and low


def _starts(scene: Scene) -> Iterator[LinkState]:
    """Yield the state at rest, then such that turn, or move along the tail, either way."""
    at_rest, rate = start_state(scene), scene.gait.omega_rad_s
    # Half the gait's rate, and 0.3 body lengths times it, lead to the other motion if there is one.
    for spin, push in ((0, 0), (0.5, 0), (-0.5, 0), (0, 0.3), (0, -0.3)):
        ahead_m_s, turn_rad_s = push * scene.robot.body_length_m * rate, spin * rate
        yield replace(
            at_rest,
            vx_m_s=at_rest.vx_m_s + ahead_m_s - turn_rad_s * (at_rest.y_m - at_rest.y_m.mean()),
            vy_m_s=at_rest.vy_m_s + turn_rad_s * (at_rest.x_m - at_rest.x_m.mean()),
            omega_rad_s=at_rest.omega_rad_s + turn_rad_s,
        )


def _settled(scene: Scene, reported: Array, until: float, repeated: float = 2e-3) -> Array | None:
    """Return the motion to which a scene settles, or the first one like the reported one.

    A motion is what a cycle turns, rad, and travels, body lengths. It repeats once it changes from
    run to run by less than a share, `repeated`, of its distance to the reported one.
    """
    motion, change = None, math.inf
    while change > repeated:
        if monotonic() > until:
            return None
        try:
            run = simulate(scene)
        except Diverged:
            return None
        travel_m = np.hypot(*np.diff(run.centre_m[-5:], axis=0).T).mean()
        turn_rad = (run.theta_rad[-1, 0] - run.theta_rad[-5, 0]) / 4
        previous, motion = motion, np.array([turn_rad, travel_m / scene.robot.body_length_m])
        if _same(motion, reported):
            break
        if previous is not None:
            change = math.dist(motion, previous) / math.dist(motion, reported)
        scene = replace(scene, start=run.state())
    return motion


def _same(motion: Array, reported: Array) -> bool:
    # They differ by less than 1 % of what a cycle turns and travels, and of 0.1 more.
    return math.dist(motion, reported) < 0.01 * (0.1 + math.hypot(*reported))
