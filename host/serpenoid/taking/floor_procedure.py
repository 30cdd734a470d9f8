"""The procedure on a floor: from a session's readings to the next push. Pure, as the treadmill's.

Straight first, then every bend with its protractor check; half of the pushes one way, half the
other, turning the robot round each time. Gait runs close the loop.
"""

from __future__ import annotations

import math

from ..session.declaration import Values
from ..session.push import Push
from ..session.session import Session
from ..session.settings import Setup
from .bends import bend_step
from .expected import USUAL, USUAL_KG, Series, of_series, pull_of
from .steps import Step

SPEED_M_S = 0.9  # to be pushed at: slower ones tell little of viscous friction
SPARE = 1.6  # of the way that is expected: room to leave for it


def push_name(series: Series) -> str:
    """Return what people call a series of pushes."""
    name = series.key.removeprefix("pushes ")
    return f"pushes, {f'bend {name} deg' if series.lambda_rad else name}"


def push_pose(setup: Setup, series: Series) -> Step:
    """Return the step to the pose of a series of pushes."""
    room = SPARE * expected_way_m(setup, series.lambda_rad, SPEED_M_S) + 0.5
    if not series.lambda_rad:
        return Step(
            series.key,
            "straight",
            f"On the floor, robot straight: align its links along a straightedge. Room: {room:.1f} "
            "m of level, even floor. Film from a tripod, square to the way or from above, all of "
            "the way in the picture; or lay a tape along it.",
        )
    then = f"It rolls less far: {room:.1f} m of room will do."
    return bend_step(series.key, setup, series.bend_deg, then)


def push_step(session: Session, series: Series) -> Step | None:
    """Return the next push of a series, its bend still to be told; None where all are done."""
    plan, done = session.setup.plan, of_series(session, series)
    key = f"push {series.key.removeprefix('pushes ')} {len(done) + 1}"
    if len(done) >= plan.pushes or key in session.skipped:
        return None
    there = sum(p.way == "there" for p in done)
    way = "there" if there <= len(done) - there else "back"
    turn = "Turn the robot round. " if done else ""
    far_m = expected_way_m(session.setup, series.lambda_rad, SPEED_M_S)
    bend_deg = math.degrees(series.lambda_rad)
    bend = f", bend {bend_deg:g} deg" if bend_deg else ", straight"
    say = (
        f"Push {len(done) + 1} of {plan.pushes}{bend}, {way.upper()}. {turn}Push it along its own "
        f"axis, head first, at a brisk walk ({SPEED_M_S:g} m/s; it then rolls some {far_m:.1f} m), "
        "let go within a hand's breadth, and leave it until it rests."
        + " One film may hold all of them, the robot turned round after each."
        * (plan.pushes > 1)
    )
    cells: Values = {
        "way": way,
        **({"bend": plan.bend} if bend_deg else {}),
    }
    fields = Push.asked("distance_m", "duration_s", "turned_deg")
    bent = series.bend_deg
    return Step(key, "push", say, fields, bent, bend=plan.bend, cells=cells, series=series)


def expected_way_m(setup: Setup, bend_rad: float, speed_m_s: float) -> float:
    """Return how far a robot as that of 2005 would roll, its friction scaled by the weight."""
    c, f = (pull / USUAL_KG for pull in pull_of(setup, USUAL, bend_rad))
    stop = math.log(1 + c * speed_m_s / f) / c
    return (speed_m_s - f * stop) / c
