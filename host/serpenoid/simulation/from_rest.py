"""Whether a gait comes to its reported periodic state from rest, or to another motion."""

from __future__ import annotations

import math
from dataclasses import replace
from time import monotonic

import numpy as np

from ..model.errors import Diverged
from ..periodic.steady import Steady
from .judge import exact_scene
from .scene import Scene
from .simulate import simulate

_AGREES = 0.01  # of what a cycle turns and travels, rad and body lengths, and of 0.1 more
_REPEATS = 0.02  # of how far a motion is off: what it still changes from one run to the next
_LONGEST_S = 2.0  # of waiting


def elsewhere(state: Steady) -> str:
    """Return in a sentence what motion a gait ends in from rest; "" if in its reported state.

    Runs follow the motion until it agrees with the state, or repeats where it does not. One that
    does neither in two seconds of waiting gives no sentence: it may only settle slowly.
    """
    gait, ground, body_m = state.gait, state.ground, state.robot.body_length_m
    if ground.smooth and ground.ct_forward == ground.ct_backward:
        return ""  # linear equations have one periodic state
    period, until = gait.period_s, monotonic() + _LONGEST_S
    cycles = math.ceil(min(max(state.settling_time_s / period, 10), 100))
    scene = Scene(state.robot, ground, gait, dt_s=period, duration_s=cycles * period)
    scene, before = exact_scene(scene, 1e-5), np.array(math.inf)
    reported = np.array([state.turn_rad_per_cycle, state.chord_m_s * period / body_m])
    while monotonic() < until:
        try:
            run = simulate(scene)
        except Diverged:
            break
        travel_m = np.hypot(*np.diff(run.centre_m[-5:], axis=0).T).mean()
        turn_rad = (run.theta_rad[-1, 0] - run.theta_rad[-5, 0]) / 4
        now = np.array([turn_rad, travel_m / body_m])
        off = np.linalg.norm(now - reported)
        if off < _AGREES * (0.1 + np.linalg.norm(reported)):
            break
        if np.linalg.norm(now - before) < _REPEATS * off:
            turns = ", the reported state ".join(
                f"turns {math.degrees(turn):.3g} deg and goes {way * body_m:.3g} m"
                for turn, way in (now, reported)
            )
            return f"from rest the robot ends in another motion: a cycle {turns}"
        before, scene = now, replace(scene, start=run.state())
    return ""
