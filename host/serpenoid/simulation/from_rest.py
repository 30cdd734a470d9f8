"""Which motion a gait settles to from rest, and whether it has another stable one beside it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from time import monotonic

import numpy as np

from ..base.errors import Diverged
from ..model.link_state import LinkState
from ..periodic.steady import FromRest, Motion, Steady
from .scene import Scene, exact_scene
from .simulate import simulate
from .starts import start_state

_SAME = 0.01  # of what a cycle turns and travels, rad and body lengths, and of 0.1 more
# Of the distance to the reported motion: what a settled motion may still change from run to run,
# and what one may where the time is over.
_REPEATS, _NEARLY_REPEATS = 1e-3, 0.02
_LONGEST_S = 2.0  # of waiting
_TOLERANCE = 1e-5  # local, of the runs
_CYCLES = 10, 100, 6000  # of one run: fewest, most on dry ground, most on viscous ground
# On viscous ground 43 of 3200 random robots had two stable motions, in bent gaits: with cn / ct up
# to 0.33, and ct over mass and rate of the gait up to 0.02. These are two and three times that.
_LOW_GRIP, _LOW_DAMPING = 0.6, 0.06
_SPIN = 0.5  # of the gait's rate: turning rate of a start that may lead to the other motion
_PUSH = 0.3  # of body length times rate: speed of such a start


def from_rest(state: Steady) -> FromRest | None:
    """Return where a start from rest leads, and the other stable motion if there is one.

    Runs follow the motion until it agrees with the reported state, or repeats where it does not.
    Where viscous ground may have two motions, runs from other starts look for the second. None:
    after two seconds of waiting it did neither; it may only settle slowly.
    """
    gait, ground, until = state.gait, state.ground, monotonic() + _LONGEST_S
    if ground.smooth and not _may_have_two_motions(state):
        return FromRest(True, None)
    most = _CYCLES[2] if ground.smooth else _CYCLES[1]
    cycles = math.ceil(min(max(state.settling_time_s / gait.period_s, _CYCLES[0]), most))
    scene = Scene(state.robot, ground, gait, dt_s=gait.period_s, duration_s=cycles * gait.period_s)
    scene = exact_scene(scene, _TOLERANCE)
    for k, start in enumerate(_starts(scene) if ground.smooth else [start_state(scene)]):
        reached = _settled(replace(scene, start=start), state, until)
        if k == 0 and reached is None:
            return None
        if reached is not None and not _same(reached, state):
            return FromRest(k > 0, reached)
    return FromRest(True, None)


def two_motions_text(state: Steady) -> str:
    """Return the two stable motions of a gait and which one a start from rest reaches, or ""."""
    if state.from_rest is None or state.from_rest.other is None:
        return ""
    other, reported = (
        f"turns {math.degrees(motion.turn_rad_per_cycle):.3g} deg and goes "
        f"{motion.chord_m_s * state.gait.period_s:.3g} m a cycle"
        for motion in (state.from_rest.other, state)
    )
    if state.from_rest.reaches_reported:
        return (
            "this gait has two stable motions: from rest the robot ends in the reported one, which "
            f"{reported}; the other {other}"
        )
    return (
        f"this gait has two stable motions: from rest the robot ends in the one that {other}; the "
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
    rest = start_state(scene)
    yield rest
    x_m, y_m = np.array(rest.x_m), np.array(rest.y_m)
    rate = scene.gait.omega_rad_s
    speed_m_s = _PUSH * scene.robot.body_length_m * rate
    heading = rest.theta_rad[0]
    for way in (1.0, -1.0):
        spin = way * _SPIN * rate
        yield replace(
            rest,
            vx_m_s=np.array(rest.vx_m_s) - spin * (y_m - y_m.mean()),
            vy_m_s=np.array(rest.vy_m_s) + spin * (x_m - x_m.mean()),
            omega_rad_s=np.array(rest.omega_rad_s) + spin,
        )
    for way in (1.0, -1.0):
        yield replace(
            rest,
            vx_m_s=np.array(rest.vx_m_s) + way * speed_m_s * math.cos(heading),
            vy_m_s=np.array(rest.vy_m_s) + way * speed_m_s * math.sin(heading),
        )


def _settled(scene: Scene, state: Steady, until: float) -> Motion | None:
    """Return the motion to which a scene settles, or the first one like the reported state."""
    before, change = None, math.inf  # over the distance to the reported motion
    while monotonic() < until:
        try:
            run = simulate(scene)
        except Diverged:
            return None
        travel_m = np.hypot(*np.diff(run.centre_m[-5:], axis=0).T).mean()
        turn_rad = (run.theta_rad[-1, 0] - run.theta_rad[-5, 0]) / 4
        now = Motion(float(turn_rad), float(travel_m / state.gait.period_s))
        if _same(now, state):
            return now
        if before is not None:
            change = _distance(now, before, state) / _distance(now, state, state)
        if change < _REPEATS:
            return now
        before, scene = now, replace(scene, start=run.state())
    return before if change < _NEARLY_REPEATS else None


def _cycle(motion: Motion | Steady, state: Steady) -> np.ndarray:
    """Return what a cycle turns, rad, and how far it goes, body lengths: (2,)."""
    travel_m = motion.chord_m_s * state.gait.period_s
    return np.array([motion.turn_rad_per_cycle, travel_m / state.robot.body_length_m])


def _distance(one: Motion | Steady, other: Motion | Steady, state: Steady) -> float:
    return float(np.linalg.norm(_cycle(one, state) - _cycle(other, state)))


def _same(motion: Motion, state: Steady) -> bool:
    limit = _SAME * (0.1 + np.linalg.norm(_cycle(state, state)))
    return _distance(motion, state, state) < limit
