"""The procedure on a floor: from a session's readings to the next push. Pure, as the treadmill's.

Straight first, then every bend with its protractor check; half of the pushes one way, half the
other, turning the robot round each time. Gait runs close the loop.
"""

from __future__ import annotations

import math

from ...kinds.coast import FACINGS, Coast
from ...session import Procedure, Session, Setup
from ..bends import bend_step
from ..expected import USUAL, USUAL_KG, of_series, pull_of, shown_bend
from ..steps import Step

SPEED_M_S = 0.9  # to be pushed at: slower ones tell little of viscous friction
SPARE = 1.6  # of the way that is expected: room to leave for it


def next_push(session: Session, skipped: frozenset[str], posed_deg: float | None) -> Step | None:
    """Return the next step of pushes, None when all are done. Parameters as of `next_step`."""
    plan = session.setup.procedure
    for bend_rad, facing in series_of_pushes(plan):
        name = series_name(bend_rad, facing)
        done = of_push_bend(session, bend_rad, facing)
        key = f"push {name} {len(done) + 1}"
        if len(done) >= plan.pushes or key in skipped or f"pushes {name}" in skipped:
            continue
        bend_deg = round(math.degrees(bend_rad), 3)
        shown_rad = shown_bend(session, bend_rad)
        if posed_deg != bend_deg or shown_rad is None:
            return _pose(session.setup, bend_deg, f"pushes {name}")
        return _push(session, bend_rad, shown_rad, facing, done)
    return None


def series_of_pushes(plan: Procedure) -> list[tuple[float, str]]:
    """Return bend and facing of the plan's pushes; straight ratchets go tail first, too."""
    facings = [
        (bend, FACINGS if plan.ratchet and not bend else FACINGS[:1])
        for bend in plan.push_lambda_rad
    ]
    return [(bend, facing) for bend, both in facings for facing in both]


def series_name(bend_rad: float, facing: str) -> str:
    """Return what events call the pushes of a bend that went one way first."""
    bend = f"{math.degrees(bend_rad):.5g}" if bend_rad else "straight"
    return bend + (" tail first" if facing == "back" else "")


def of_push_bend(session: Session, bend_rad: float, facing: str = "ahead") -> list[Coast]:
    """Return the kept pushes of one of the plan's bends, head or tail first."""
    return of_series(session, session.kept_pushes, bend_rad, facing)


def push_progress(session: Session, skipped: frozenset[str]) -> list[tuple[str, str]]:
    """Return the parts of the plan and how far each is, in words."""
    plan = session.setup.procedure
    rows = []
    for bend_rad, facing in series_of_pushes(plan):
        name = series_name(bend_rad, facing)
        count = len(of_push_bend(session, bend_rad, facing))
        left_out = f"pushes {name}" in skipped or f"push {name} {count + 1}" in skipped
        state = f"{count} of {plan.pushes}{', the rest left out' if left_out else ''}"
        rows.append((f"pushes, {f'bend {name} deg' if bend_rad else name}", state))
    return rows


def _pose(setup: Setup, bend_deg: float, key: str) -> Step:
    room = SPARE * expected_way_m(setup, math.radians(bend_deg), SPEED_M_S) + 0.5
    if not bend_deg:
        return Step(
            key,
            "straight",
            f"On the floor, robot straight: align its links along a straightedge. Room: {room:.1f} "
            "m of level, even floor. Film from a tripod, square to the way or from above, all of "
            "the way in the picture; or lay a tape along it.",
        )
    return bend_step(key, setup, bend_deg, f"It rolls less far: {room:.1f} m of room will do.")


def _push(
    session: Session, bend_rad: float, shown_rad: float, facing: str, done: list[Coast]
) -> Step:
    plan = session.setup.procedure
    key = f"push {series_name(bend_rad, facing)} {len(done) + 1}"
    first = "head first" if facing == "ahead" else "TAIL FIRST, so that its wheels roll backwards"
    there = sum(p.way == "there" for p in done)
    way = "there" if there <= len(done) - there else "back"
    turn = "Turn the robot round. " if done else ""
    far_m = expected_way_m(session.setup, bend_rad, SPEED_M_S)
    bend = f", bend {math.degrees(bend_rad):g} deg" if bend_rad else ", straight"
    say = (
        f"Push {len(done) + 1} of {plan.pushes}{bend}, {way.upper()}. {turn}Push it along its own "
        f"axis, {first}, at a brisk walk ({SPEED_M_S:g} m/s; it then rolls some {far_m:.1f} m), "
        "let go within a hand's breadth, and leave it until it rests."
    )
    cells: dict[str, float | str] = {
        "lambda_deg": round(math.degrees(shown_rad), 4),
        "way": way,
        **({"bend": plan.bend} if bend_rad else {}),
        **({"facing": facing} if facing == "back" else {}),
    }
    fields = Coast.asked("distance_m", "duration_s", "turned_deg")
    return Step(
        key, "coast", say, fields, round(math.degrees(bend_rad), 3), bend=plan.bend, cells=cells
    )


def expected_way_m(setup: Setup, bend_rad: float, speed_m_s: float) -> float:
    """Return how far a robot as that of 2005 would roll, its friction scaled by the weight."""
    c, f = (pull / USUAL_KG for pull in pull_of(setup, USUAL, bend_rad))
    stop = math.log(1 + c * speed_m_s / f) / c
    return (speed_m_s - f * stop) / c
