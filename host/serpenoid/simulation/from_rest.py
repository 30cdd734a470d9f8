"""Where a start from rest leads: to the reported periodic state, or to another stable motion."""

from __future__ import annotations

import math
from dataclasses import replace
from time import monotonic

import numpy as np

from ..base.errors import Diverged
from ..periodic.steady import FromRest, Motion, Steady
from .scene import Scene, exact_scene
from .simulate import simulate


def from_rest(state: Steady, time_limit_s: float = 2.0, repeated: float = 2e-3) -> FromRest | None:
    """Return where a start from rest leads; None if that takes longer than the limit, s.

    A motion is what a cycle turns, rad, and travels, body lengths. A run goes on until it agrees
    with the reported motion, or until another one repeats: it changes from run to run by less than
    a share, `repeated`, of its distance to the reported one.
    """
    gait, ground = state.gait, state.ground
    if ground.smooth and not _may_have_two_motions(state):
        return FromRest(True, None)
    cycles_limit = 6000 if ground.smooth else 100
    cycles = math.ceil(np.clip(state.settling_time_s / gait.period_s, 10, cycles_limit))
    scene = Scene(state.robot, ground, gait, dt_s=gait.period_s, duration_s=cycles * gait.period_s)
    scene = exact_scene(scene, 1e-5)
    body_m, until = state.robot.body_length_m, monotonic() + time_limit_s
    reported = state.turn_rad_per_cycle, state.chord_m_s * gait.period_s / body_m
    motion, change = (math.inf, math.inf), math.inf
    while change > repeated:
        if monotonic() > until:
            return None
        try:
            run = simulate(scene)
        except Diverged:
            return None
        travel_m = float(np.hypot(*np.diff(run.centre_m[-5:], axis=0).T).mean())
        turn_rad = float(run.theta_rad[-1, 0] - run.theta_rad[-5, 0]) / 4
        previous, motion = motion, (turn_rad, travel_m / body_m)
        distance = math.dist(motion, reported)
        # They agree within 1 % of what a cycle turns and travels, and of 0.1 more.
        if distance < 0.01 * (0.1 + math.hypot(*reported)):
            return FromRest(True, None)
        change = math.dist(motion, previous) / distance
        scene = replace(scene, start=run.state())
    turn_rad, lengths = motion
    return FromRest(False, Motion(turn_rad, lengths * body_m / gait.period_s))


def two_motions_text(state: Steady) -> str:
    """Return the two stable motions of a gait if a start from rest leads to the other, or ""."""
    if state.from_rest is None or state.from_rest.other is None:
        return ""
    second, reported = (
        f"turns {math.degrees(motion.turn_rad_per_cycle):.3g} deg and goes "
        f"{motion.chord_m_s * state.gait.period_s:.3g} m a cycle"
        for motion in (state.from_rest.other, state)
    )
    return (
        f"this gait has two stable motions: the reported one {reported}; a start from rest ends in "
        f"the other, which {second}"
    )


def _may_have_two_motions(state: Steady) -> bool:
    """Return whether viscous friction is so low, and grips so little, that bends may have two.

    Of 3200 random robots 43 had two stable motions, in bent gaits: with cn / ct up to 0.33, and ct
    over mass and rate of the gait up to 0.02. The limits are two and three times that.
    """
    ground, ct = state.ground, state.ground.ct_forward
    low = ct < 0.06 * state.robot.link_mass_kg * state.gait.omega_rad_s
    return state.gait.offset_rad != 0 and ground.cn < 0.6 * ct and low
