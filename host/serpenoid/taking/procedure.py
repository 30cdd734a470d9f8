"""The procedure: from a session's readings to the next step. Pure; nothing is asked or shown here.

On a treadmill: inclinometer zero by reversal; straight, stations from the first incline up to the
top belt speed; each bend with its protractor check, then its stations; the zero again. On a floor:
pushes there and back, straight and in each bend. Gait runs end both. Where a session stands follows
from its rows alone, so that resuming is nothing special. Only the plan and what was read count, no
friction.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Set
from dataclasses import replace

from ..servos.catalogue import HOBBY
from ..servos.speed_limit import too_fast_text
from ..session.crawls import driving
from ..session.declaration import Cells, Range, Values
from ..session.gait_run import RUN_WAYS, GaitRun
from ..session.push import Push
from ..session.session import Session, belt_checks
from ..session.settings import Setup
from ..session.station import LEAST_SLIP_M_S, BeltCheck, Reading, ZeroReading
from .steps import (
    Doubts,
    Step,
    bend_step,
    friction_factor,
    line_of,
    planned_bends,
    pose_key,
    shown_bend,
    step_in_words,
    taken_in,
)

ZERO_BEFORE, ZERO_AFTER, BELT_CHECK = "zero before", "zero after", "belt check"
_ZERO = (
    "Inclinometer zero. Lay it on one spot of the treadmill, read it; turn it end for end on the "
    "same spot, read it again (with the sign it shows)."
)
_BELT = (
    "Belt check, robot off the belt: mark the belt's edge, run it at a speed that you used much, "
    "and time ten turns or more. The way is turns times the belt's length."
)
_BENDS_HELP = "(7.5 deg tells cn to 35 %, 15 deg to 10 %, 30 deg to 4 %.)"
MAX_INCLINE_DEG = 12.0  # steeper, the snake starts to tumble, or the wheels to slide
MAX_ZERO_DEG = 0.5  # beyond it an inclinometer's sign was forgotten, or it is not one to use
SETTLE_TIMES = 3.0  # of m / C_t, after which 5 % of a disturbance is left
SLOPE_M_S = 53.0  # m/s of belt speed over sin(incline), m g / C_t of the 2005 robot
STATIONS = 5  # of a bend, about, spread from rest to the top speed
DONE_SHARE = 0.85  # of the top speed: a station above it ends a bend, as one beyond 1 / 0.85 would
SLOW_SHARE = 0.25  # of the top speed: a bend needs a station below it, which tells dry friction
NOISE_SIGMAS, LINE_SHARE = 4.0, 0.5  # of a station's noise, and of the way from the line's middle
PUSH_M_S = 0.9  # slower pushes tell little of viscous friction
ROLLS_M = 1.0  # so far the straight 2005 robot rolls then, whatever it weighs
SPARE = 1.6  # room to leave for a push, over the way that is expected


def next_step(session: Session, posed_deg: float | None = None) -> Step:
    """Return what to do next; kind "done" when nothing is left.

    posed_deg: how the robot lies now, the plan's bend in degrees; None when that is not known, as
    at the start.
    """
    step = next((step for _, _, step in _parts(session) if step is not None), None)
    if step is None:
        left_out = len(session.skipped)
        but = f", but for {left_out} left out" if left_out else ""
        return Step("done", "done", f"all of the plan is done{but}")
    if step.kind not in ("station", "push"):
        return step
    shown_deg = shown_bend(session, step.lambda_deg)
    if posed_deg != step.lambda_deg or shown_deg is None:
        return _pose(session.setup, step.lambda_deg)
    return replace(step, cells={"lambda_deg": round(shown_deg, 4)} | step.cells)


def progress(session: Session) -> list[tuple[str, str]]:
    """Return the parts of the plan and how far each is, in words."""
    return [(name, state) for name, state, _ in _parts(session)]


def _parts(session: Session) -> Iterator[tuple[str, str, Step | None]]:
    """Yield the parts of the plan: name, how far it is, and its next step, None where none is."""
    plan, skipped = session.setup.plan, session.skipped
    floor, begun = plan.on == "floor", bool(session.kept_stations)
    zeros = [zero.at_start for zero in session.kept_of("zero")]
    if not floor:
        open_ = not begun and ZERO_BEFORE not in skipped
        zero = Step(ZERO_BEFORE, "zero", _ZERO, ZeroReading.questions())
        yield _check(zero, True in zeros, open_)
    for bend_deg in planned_bends(plan):
        key, count = pose_key(plan, bend_deg), len(taken_in(session, bend_deg))
        step = _push(session, bend_deg) if floor else _station(session, bend_deg)
        step = None if key in skipped else step
        planned = f" of {plan.pushes}" if floor else " stations"
        state = ", more to come" if step else ", done" if count else ", left out"
        yield step_in_words(key), f"{count}{planned}{state}", step
    if not floor:
        zero = Step(ZERO_AFTER, "zero", _ZERO, ZeroReading.questions())
        yield _check(zero, False in zeros, begun and ZERO_AFTER not in skipped)
        belt = Step(BELT_CHECK, "belt", _BELT, BeltCheck.questions())
        yield _check(belt, bool(belt_checks(session)), begun and BELT_CHECK not in skipped)
    runs = f"{len(session.kept_crawls)} of {len(plan.gaits) * plan.gait_runs}"
    yield "gait runs", runs, _gait_run(session, skipped)


def _check(step: Step, done: bool, due: bool) -> tuple[str, str, Step | None]:
    return step.key, "done" if done else "open", step if due and not done else None


def _pose(setup: Setup, bend_deg: float) -> Step:
    """Return the step to a pose of the plan."""
    plan, room_m = setup.plan, SPARE * ROLLS_M / friction_factor(bend_deg) + 0.5
    key, floor = pose_key(plan, bend_deg), plan.on == "floor"
    if bend_deg:
        hint = f"It rolls less far: {room_m:.1f} m of room will do." if floor else _BENDS_HELP
        return bend_step(key, setup, bend_deg, hint)
    if floor:
        say = (
            "On the floor, robot straight: align its links along a straightedge. Room: "
            f"{room_m:.1f} m of level, even floor. Film from a tripod, square to the way or from "
            "above, all of the way in the picture; or lay a tape along it."
        )
    else:
        say = "Robot straight, on the belt, head downhill, the belt running uphill."
    return Step(key, "straight", say)


def _push(session: Session, bend_deg: float) -> Step | None:
    """Return the next push in a pose; None where all are done."""
    plan, done = session.setup.plan, taken_in(session, bend_deg)
    pose = pose_key(plan, bend_deg).removeprefix("pushes ")
    key = f"push {pose} {len(done) + 1}"
    if len(done) >= plan.pushes or key in session.skipped:
        return None
    forward = sum(push.way == "there" for push in done)
    way = "there" if 2 * forward <= len(done) else "back"
    words = f"bend {pose} deg" if bend_deg else pose
    say = (
        f"Push {len(done) + 1} of {plan.pushes}, {words}, {way.upper()}. "
        + "Turn the robot round. " * bool(done)
        + f"Push it along its own axis, head first, at a brisk walk ({PUSH_M_S:g} m/s; it then "
        f"rolls some {ROLLS_M / friction_factor(bend_deg):.1f} m), let go within a hand's breadth, "
        "and leave it until it rests."
        + " One film may hold all of them, the robot turned round after each."
        * (plan.pushes > 1)
    )
    cells: Values = {"way": way}
    cells |= {"bend": plan.bend} if bend_deg else {}
    fields = Push.questions("distance_m", "duration_s", "turned_deg")
    return Step(key, "push", say, fields, bend_deg, cells=cells)


def next_incline_deg(session: Session, bend_deg: float) -> float | None:
    """Return the incline of a bend's next station, None when it needs no more.

    The first is the plan's, or the least at which a lesser bend held, made steeper as its friction
    asks. While all stations are fast, the next is less steep, because slow stations tell dry
    friction. Otherwise it is steeper: by the plan's step, or by what raises the speed by a fifth of
    the top speed. A bend is done when that would pass the top speed, or the incline at which the
    snake tumbles.
    """
    plan, top_m_s = session.setup.plan, session.setup.plan.belt_speed_max_m_s
    stations = taken_in(session, bend_deg)
    left_out = [
        float(key.split()[2]) for key in session.skipped if key.startswith(_station_key(bend_deg))
    ]
    inclines_deg = [math.degrees(station.incline_rad) for station in stations]
    tried = inclines_deg + left_out
    if not tried:
        return _first_incline_deg(session, bend_deg)
    # The treadmill's own step at least, or its rounding could stay below for ever.
    step_deg = math.degrees(max(plan.incline_step_rad, session.setup.instruments.incline_step_rad))
    speeds = [station.slip_speed_m_s for station in stations]
    lowest_deg, fastest_m_s = min(tried), max(speeds, default=0.0)
    line = line_of(session, bend_deg)
    step_deg *= 1.0 if line else friction_factor(bend_deg)
    if min(speeds, default=0.0) > SLOW_SHARE * top_m_s and step_deg < lowest_deg in inclines_deg:
        return round(lowest_deg - step_deg, 3)
    next_deg, next_m_s = max(tried) + step_deg, fastest_m_s
    if line is not None:
        next_deg = max(next_deg, line.incline_deg(fastest_m_s + top_m_s / STATIONS))
        next_m_s = line.speed(math.sin(math.radians(next_deg)))
    done = max(fastest_m_s, DONE_SHARE**2 * next_m_s) > DONE_SHARE * top_m_s
    return None if done or next_deg > MAX_INCLINE_DEG else round(next_deg, 3)


def _station_key(bend_deg: float) -> str:
    return f"station {bend_deg:g} "


def _first_incline_deg(session: Session, bend_deg: float) -> float:
    plan, inclines = session.setup.plan, [session.setup.plan.incline_start_deg]
    for lesser_deg in planned_bends(plan):
        factor = friction_factor(bend_deg) / friction_factor(lesser_deg)
        inclines_deg = [
            math.degrees(station.incline_rad) for station in taken_in(session, lesser_deg)
        ]
        if lesser_deg < bend_deg and inclines_deg:
            inclines.append(factor * min(inclines_deg))
    return round(min(max(inclines), MAX_INCLINE_DEG), 3)


def expected_speed(session: Session, bend_deg: float, incline_deg: float) -> Range:
    """Return the range of belt speeds past the robot that is expected at a station, m/s."""
    line = line_of(session, bend_deg)
    if line is None:
        return LEAST_SLIP_M_S, session.setup.plan.belt_speed_max_m_s
    speed_m_s = line.speed(math.sin(math.radians(incline_deg)))
    off_m_s = NOISE_SIGMAS * line.noise_m_s + LINE_SHARE * abs(speed_m_s - line.mean_m_s)
    return max(speed_m_s - off_m_s, LEAST_SLIP_M_S), speed_m_s + off_m_s


def doubts(session: Session, step: Step, cells: Cells) -> Doubts:
    """Return the fields whose numbers are not where they were expected, and where that is.

    A station's belt speed is judged at the incline that was typed, with the drift taken off.
    """
    likely = {field.column: field.likely for field in step.fields}
    if step.kind == "station":
        incline_deg = float(cells.get("incline_deg", step.incline_deg))
        low, high = expected_speed(session, step.lambda_deg, incline_deg)
        drift_m_s = float(cells.get("drift_m_s", 0.0))
        likely["belt_speed_m_s"] = low + drift_m_s, high + drift_m_s
    if step.kind == "zero":  # turned end for end it shows the same with the other sign
        other_deg = -float(cells["incline_deg"])
        likely["reversed_deg"] = other_deg - 2 * MAX_ZERO_DEG, other_deg + 2 * MAX_ZERO_DEG
    doubtful = []
    for field in step.fields:
        low, high = likely[field.column] or (-math.inf, math.inf)
        if field.column in cells and not low <= float(cells[field.column]) <= high:
            doubtful.append((field, (low, high)))
    return doubtful


def _station(session: Session, bend_deg: float) -> Step | None:
    """Return the next station of a bend; None where all are done."""
    incline_deg = next_incline_deg(session, bend_deg)
    if incline_deg is None:
        return None
    plan, first = session.setup.plan, not taken_in(session, bend_deg)
    line = line_of(session, bend_deg) or line_of(session, 0.0)
    slope_m_s = SLOPE_M_S if line is None else line.slope
    settle_s = SETTLE_TIMES * slope_m_s / session.setup.laboratory.gravity_m_s2
    steeper = f" Steeper, if the belt carries it off, or below {LEAST_SLIP_M_S:g} m/s."
    hint, likely = "", None
    if line_of(session, bend_deg) is not None:
        low, high = expected_speed(session, bend_deg, incline_deg)
        likely = low, high
        hint = f", about {low:.2f} to {high:.2f} m/s ({3.6 * low:.1f} to {3.6 * high:.1f} km/h)"
    say = (
        f"Incline to about {incline_deg:.1f} deg "
        f"({100 * math.tan(math.radians(incline_deg)):.1f} %). Raise the belt until the robot "
        f"holds its place{hint}, or nearly. Type the belt's speed then, and let it settle "
        f"{settle_s:.0f} s; or film it for some 4 s, and type its places."
        f"{steeper * first}"
    )
    # A misread first station leads its whole bend astray: straight, a far one is asked about.
    far_deg = 2 * plan.incline_step_deg
    high_deg = MAX_INCLINE_DEG if first and bend_deg else incline_deg + far_deg
    shown, belt, waited = Reading.questions("incline_deg", "belt_speed_m_s", "waited_s")
    return Step(
        f"{_station_key(bend_deg)}{incline_deg:.2f}",
        "station",
        say,
        (
            replace(shown, likely=(incline_deg - far_deg, high_deg)),
            replace(belt, likely=likely),
            *Reading.questions("drift_m_s", "turned_deg"),
            replace(waited, likely=(settle_s / 2, math.inf), why=f"let it settle {settle_s:.0f} s"),
        ),
        bend_deg,
        incline_deg,
        settle_s,
        cells={"bend": plan.bend} if bend_deg else {},
    )


def _gait_run(session: Session, skipped: Set[str]) -> Step | None:
    """Return the next gait run of the plan; None where all are done."""
    plan = session.setup.plan
    for number, gait in enumerate(plan.gaits, 1):
        runs = [
            run
            for run in session.kept_crawls
            if math.isclose(run.alpha_rad, gait.alpha_rad, abs_tol=1e-3)
            and math.isclose(run.beta_rad, gait.beta_rad, abs_tol=1e-3)
            and math.isclose(run.omega_rad_s, gait.omega_rad_s, rel_tol=0.05)
        ]
        key = f"gait {number}.{len(runs) + 1}"
        if len(runs) >= plan.gait_runs or skipped & {key, f"gait {number}"}:
            continue
        alpha_deg, beta_deg = math.degrees(gait.alpha_rad), math.degrees(gait.beta_rad)
        # On a floor there and back, so that its slope cancels.
        way = RUN_WAYS[1 + len(runs) % 2] if plan.on == "floor" else ""
        where = f"along the line of the pushes, {way.upper()}" if way else "level ground"
        say = (
            f"Gait run {len(runs) + 1} of {plan.gait_runs}, {where}, of the same surface: "
            f"alpha {alpha_deg:g} deg, beta {beta_deg:g} deg, "
            f"{gait.omega_rad_s / (2 * math.pi):.3g} Hz. Once it goes steadily, film it from above "
            "for two cycles at least, or time it between two marks. "
            f"{too_fast_text(gait, driving(session.setup, HOBBY))}"
        )
        cells: Values = {
            "alpha_deg": round(alpha_deg, 6),
            "beta_deg": round(beta_deg, 6),
            "omega_rad_s": gait.omega_rad_s,
        }
        cells |= {"way": way} if way else {}
        time, marks = GaitRun.questions("duration_s", "distance_m")
        if session.kept_gait_runs:  # the marks are still there
            marks_m = session.kept_gait_runs[-1].distance_m
            words = f"{marks.words} (Enter: {marks_m:g} m)"
            marks = replace(marks, words=words, usual=marks_m)
        return Step(key, "gait", say.rstrip(), (time, marks), gait=gait, cells=cells)
    return None
