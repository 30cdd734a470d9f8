"""The steps of a session, and the procedure that chooses the next step from its readings.

On a treadmill: inclinometer zero by reversal; stations of the straight robot, from the first
incline up to the top belt speed; each bend with its protractor check, then its stations; the zero
again. On a floor: pushes there and back, straight and in each bend. Gait runs end both. The next
step depends only on the plan and the readings, not on fitted friction, so that an interrupted
session goes on where it stopped.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ..base.checks import count_text
from ..model.bends import bend_signs, joint_multiples
from ..model.gait import Gait, gait_name
from ..servos.catalogue import HOBBY
from ..servos.speed_limit import too_fast_text
from ..session.crawls import driving
from ..session.declaration import Cells, Field, Observation, Range, Values
from ..session.folder import KINDS
from ..session.gait_run import GaitRun
from ..session.journal import Journal
from ..session.push import WAYS, Push
from ..session.session import Session, belt_checks
from ..session.settings import Plan, Setup
from ..session.station import MIN_SLIP_M_S, BeltCheck, BendCheck, Reading, ZeroReading
from ..session.track import EXAMPLE, Samples

TUMBLING_DEG = 12.0  # Largest incline that is planned; above it the snake may tumble or slide.


class Tracked(dict[str, "float | str"]):
    """Cells of a reading, with the samples of its track.

    kind: kind of the reading; "" if it is the step's kind.
    """

    def __init__(self, cells: Cells, samples: Samples | None = None, kind: str = ""):
        super().__init__(cells)
        self.samples, self.kind = samples, kind


@dataclass(frozen=True)
class Step:
    """One step of the procedure.

    key: its name in the journal's events. kind: kind of the reading that it gives; "straight" or
    "done" if it gives none. say: instruction to the person. fields: numbers to be read.
    lambda_deg, incline_deg: the plan's bend and incline. settle_s: time to wait before reading.
    gait: the gait to be run. cells: values of the reading that the plan determines, by column.
    """

    key: str
    kind: str
    say: str
    fields: tuple[Field, ...] = ()
    lambda_deg: float = 0.0
    incline_deg: float = 0.0
    settle_s: float = 0.0
    gait: Gait | None = None
    cells: Values = field(default_factory=dict)

    @property
    def posed_deg(self) -> float | None:
        """Return the plan's bend in which the robot lies after the step, deg; None if unknown."""
        is_posed = self.kind in ("straight", "bend", "station", "push")
        return self.lambda_deg if is_posed else None


def record_step(record: Journal, step: Step, cells: Cells) -> int:
    """Write the reading of a step to the journal; return its number, 0 if the step has none."""
    if step.kind == "straight":
        return 0
    reading = cells if isinstance(cells, Tracked) else Tracked(cells)
    kind = reading.kind or step.kind
    values = KINDS[kind].derived(step.cells | reading, record.session.setup.instruments)
    return record.add(kind, values, samples=reading.samples)


def planned_bends(plan: Plan) -> tuple[float, ...]:
    """Return the bends of a plan, deg, straight included."""
    return plan.push_lambda_deg if plan.on == "floor" else plan.lambda_deg


def pose_key(plan: Plan, bend_deg: float) -> str:
    """Return the key, in the journal's events, of all readings in one bend."""
    pose = f"bend {bend_deg:g}" if bend_deg else "straight"
    return f"pushes, {pose}" if plan.on == "floor" else pose


def _nearest_bend(plan: Plan, lambda_rad: float) -> float:
    shown_deg = math.degrees(lambda_rad)
    return min(planned_bends(plan), key=lambda bend_deg: abs(bend_deg - shown_deg))


def bend_readings(session: Session, bend_deg: float) -> list[Any]:
    """Return the kept readings in one of the plan's bends: stations, or pushes on a floor."""
    plan = session.setup.plan
    return [
        reading
        for reading in session.kept_of("push" if plan.on == "floor" else "station")
        if (reading.bend == plan.bend or not reading.lambda_rad)
        and _nearest_bend(plan, reading.lambda_rad) == bend_deg
    ]


def shown_bend(session: Session, bend_deg: float) -> float | None:
    """Return a bend as the last protractor check showed it, deg; None if that was another bend."""
    if not bend_deg:
        return 0.0
    plan, checks = session.setup.plan, session.kept_of("bend")
    if not checks or checks[-1].bend != plan.bend:
        return None
    found_rad: float = checks[-1].found_rad
    return math.degrees(found_rad) if _nearest_bend(plan, found_rad) == bend_deg else None


def friction_factor(bend_deg: float) -> float:
    """Return the ratio of rolling friction, bent to straight, of the 2005 robot."""
    return 1.0 + 1.4 * math.radians(bend_deg)


def station_line(session: Session, bend_deg: float) -> tuple[float, float] | None:
    """Return slope and offset, m/s, of the line through a bend's stations.

    The line is the belt's speed past the robot as a function of sin(incline). None if there are
    fewer than two inclines, or if the line falls.
    """
    stations = bend_readings(session, bend_deg)
    sines = [math.sin(station.incline_rad) for station in stations]
    same_sine = 1e-4  # Range of the sines below which no line is fitted.
    if not sines or np.ptp(sines) < same_sine:
        return None
    slope, offset_m_s = np.polyfit(sines, [station.slip_speed_m_s for station in stations], 1)
    return (float(slope), float(offset_m_s)) if slope > 0.0 else None


def next_step(session: Session, posed_deg: float | None = None) -> Step:
    """Return the next step of the plan; its kind is "done" if no step is left.

    posed_deg: the plan's bend in which the robot lies now; None if it is not known, as at the
    start.
    """
    step = next((step for _, _, step in _parts(session) if step is not None), None)
    if step is None:
        fit = f"`serpenoid fit {session.folder or 'DIR'}` computes the friction"
        return Step("done", "done", f"Nothing of the plan is left to take; {fit}.")
    if step.kind not in ("station", "push"):
        return step
    shown_deg = shown_bend(session, step.lambda_deg)
    if posed_deg != step.lambda_deg or shown_deg is None:
        return _pose(session.setup, step.lambda_deg)
    return replace(step, cells={"lambda_deg": round(shown_deg, 4)} | step.cells)


def progress(session: Session) -> list[tuple[str, str]]:
    """Return the parts of the plan, and the progress of each in words."""
    return [(name, state) for name, state, _ in _parts(session)]


def _parts(session: Session) -> Iterator[tuple[str, str, Step | None]]:
    """Yield each part of the plan: name, progress in words, and next step (None if it has none)."""
    plan, skipped = session.setup.plan, session.skipped
    floor, begun = plan.on == "floor", bool(session.kept_stations)
    zeros = [zero.at_start for zero in session.kept_of("zero")]
    zero_words = (
        "Inclinometer zero. Lay it on one spot of the treadmill, read it; turn it end for end on "
        "the same spot, read it again (with the sign it shows)."
    )
    belt_words = (
        "Belt check, robot off the belt: mark the belt's edge, run it at a speed that you used "
        "often, and time ten turns or more. The distance is turns times the belt's length."
    )

    def check(
        key: str, kind: type[Observation], say: str, due: bool, done: bool
    ) -> tuple[str, str, Step | None]:
        is_next = due and not done and key not in skipped
        step = Step(key, kind.kind, say, kind.questions()) if is_next else None
        return key, "done" if done else "open", step

    if not floor:
        yield check("zero before", ZeroReading, zero_words, not begun, True in zeros)
    for bend_deg in planned_bends(plan):
        key, count = pose_key(plan, bend_deg), len(bend_readings(session, bend_deg))
        step = _push(session, bend_deg) if floor else _station(session, bend_deg)
        step = None if key in skipped else step
        amount = f"{count} of {plan.pushes}" if floor else count_text(count, "station")
        done = count >= (plan.pushes if floor else 1)
        state = ", more to come" if step else ", done" if done else ", the rest left out"
        yield key, amount + state, step
    if not floor:
        yield check("zero after", ZeroReading, zero_words, begun, False in zeros)
        yield check("belt check", BeltCheck, belt_words, begun, bool(belt_checks(session)))
    runs = f"{len(session.kept_crawls)} of {len(plan.gaits) * plan.gait_runs}"
    yield "gait runs", runs, _gait_run(session)


def _pose(setup: Setup, bend_deg: float) -> Step:
    """Return the step to a pose of the plan."""
    key, plan = pose_key(setup.plan, bend_deg), setup.plan
    if bend_deg:
        between_deg = 180.0 - 2 * bend_deg
        multiples = joint_multiples(bend_signs(plan.bend, setup.robot.links))
        joints = ", ".join(f"{m * bend_deg:+g}" if m else "0" for m in multiples)
        guide = " Guide the robot: left alone it turns." * (plan.bend == "zigzag")
        say = (
            f"Bend {bend_deg:g} deg, {plan.bend}: joints from the tail at {joints} deg.{guide} A "
            f"protractor between the last two links at either end shows {between_deg:g} deg."
        )
        (shown,) = BendCheck.questions("between_links_deg")
        fields = (replace(shown, likely=(between_deg - 5.0, between_deg + 5.0)),)
        return Step(key, "bend", say, fields, bend_deg, cells={"lambda_deg": bend_deg})
    belt_words = "Robot straight, on the belt, head downhill, the belt running uphill."
    floor_words = (
        "On the floor, robot straight: align its links along a straightedge. Room: 2 m of level, "
        "even floor. Film from a tripod, square to the way or from above, all of the way in the "
        "picture. Pushes by tape and watch only add to films: alone they do not tell all frictions."
    )
    return Step(key, "straight", floor_words if plan.on == "floor" else belt_words)


def _push(session: Session, bend_deg: float) -> Step | None:
    """Return the next push in a pose; None where all are done."""
    plan, done = session.setup.plan, bend_readings(session, bend_deg)
    pose = pose_key(plan, bend_deg).removeprefix("pushes, ")
    keys = [f"push {number} of {plan.pushes}, {pose}" for number in range(1, plan.pushes + 1)]
    to_come = [key for key in keys if key not in session.skipped][len(done) :]
    if not to_come:
        return None
    way = WAYS[2 * sum(push.way == "there" for push in done) > len(done)]
    push_words = (
        "Push it along its own axis, head first, at a brisk walk (0.9 m/s; straight it then rolls "
        "some 1 m), let go within a hand's breadth, and leave it until it rests. One film may hold "
        "all pushes of a bend, the robot turned round after each."
    )
    how = push_words
    if done:
        how = "For THERE its head points as at the first push, for BACK the other way."
    say = f"{to_come[0].capitalize()}, {way.upper()}. {how}"
    columns = "distance_m", "duration_s", "turned_deg"
    return Step(to_come[0], "push", say, Push.questions(*columns), bend_deg, cells={"way": way})


def next_incline_deg(session: Session, bend_deg: float) -> float | None:
    """Return the incline of a bend's next station, deg; None if the bend is done.

    The first incline is the plan's, or the lowest of a smaller bend times the ratio of the two
    bends' friction, if that is steeper. While all stations are fast, the next is less steep,
    because slow stations determine dry friction. Otherwise it is steeper: by the plan's step, or by
    what raises the speed by a fifth of the top speed. A bend is done when the next station would
    pass the top speed, or the incline at which the snake may tumble.
    """
    plan, top_m_s = session.setup.plan, session.setup.plan.belt_speed_max_m_s
    stations = bend_readings(session, bend_deg)
    skipped = [key for key in session.skipped if key.startswith(_station_key(bend_deg))]
    inclines_deg = [math.degrees(station.incline_rad) for station in stations]
    tried = inclines_deg + [float(key.split()[-2]) for key in skipped]
    if not tried:
        return _first_incline_deg(session, bend_deg)
    # With less than the treadmill's own step, its rounding could give the same incline for ever.
    step_deg = math.degrees(max(plan.incline_step_rad, session.setup.instruments.incline_step_rad))
    speeds = [station.slip_speed_m_s for station in stations]
    lowest_deg, fastest_m_s = min(tried), max(speeds, default=0.0)
    line = station_line(session, bend_deg)
    step_deg *= 1.0 if line else friction_factor(bend_deg)
    slower_deg = lowest_deg - step_deg
    is_held = slower_deg > 0.0 and (line is None or _speed_on(line, slower_deg) > MIN_SLIP_M_S)
    if min(speeds, default=0.0) > top_m_s / 4 and is_held and lowest_deg in inclines_deg:
        return round(slower_deg, 3)
    next_deg, next_m_s = max(tried) + step_deg, fastest_m_s
    if line is not None:
        slope, offset_m_s = line
        sine = (fastest_m_s + top_m_s / 5 - offset_m_s) / slope
        next_deg = max(next_deg, math.degrees(math.asin(min(max(sine, 0.0), 1.0))))
        next_m_s = _speed_on(line, next_deg)
    # A bend ends at this share of the top speed, or if the next station would pass the top speed
    # over this share.
    done_share = 0.85
    done = max(fastest_m_s, done_share**2 * next_m_s) > done_share * top_m_s
    return None if done or next_deg > TUMBLING_DEG else round(next_deg, 3)


def _station_key(bend_deg: float) -> str:
    return f"station, bend {bend_deg:g}, "


def _speed_on(line: tuple[float, float], incline_deg: float) -> float:
    """Return the belt's speed past the robot, m/s, by a line's slope and offset."""
    return line[0] * math.sin(math.radians(incline_deg)) + line[1]


def _first_incline_deg(session: Session, bend_deg: float) -> float:
    plan, inclines = session.setup.plan, [session.setup.plan.incline_start_deg]
    for lesser_deg in planned_bends(plan):
        factor = friction_factor(bend_deg) / friction_factor(lesser_deg)
        inclines_deg = [
            math.degrees(station.incline_rad) for station in bend_readings(session, lesser_deg)
        ]
        if lesser_deg < bend_deg and inclines_deg:
            inclines.append(factor * min(inclines_deg))
    return round(min(max(inclines), TUMBLING_DEG), 3)


def expected_speed(session: Session, bend_deg: float, incline_deg: float) -> Range | None:
    """Return the range of belt speeds past the robot that is expected at a station, m/s.

    None if the stations of the bend determine no line.
    """
    line = station_line(session, bend_deg)
    if line is None:
        return None
    speed_m_s = max(_speed_on(line, incline_deg), MIN_SLIP_M_S)
    # Four standard deviations of a usual station, and a share of its speed.
    far_m_s = 0.12 + 0.25 * abs(speed_m_s)
    return max(speed_m_s - far_m_s, MIN_SLIP_M_S), speed_m_s + far_m_s


def expected_ranges(session: Session, step: Step, cells: Cells) -> dict[str, Range | None]:
    """Return the expected range of each number of a step, by column; None: any value.

    A station's belt speed is compared with the range for the typed incline, plus the typed drift.
    """
    likely = {field.column: field.likely for field in step.fields}
    if step.kind == "station":
        incline_deg = float(cells.get("incline_deg", step.incline_deg))
        allowed = MIN_SLIP_M_S, session.setup.plan.belt_speed_max_m_s
        low, high = expected_speed(session, step.lambda_deg, incline_deg) or allowed
        drift_m_s = float(cells.get("drift_m_s", 0.0))
        likely["belt_speed_m_s"] = low + drift_m_s, high + drift_m_s
    if step.kind == "zero":  # turned end for end, a true inclinometer shows the negative value
        # A zero of more than 0.5 deg means a forgotten sign, or an inclinometer that is unfit.
        other_deg, max_zero_deg = -float(cells["incline_deg"]), 0.5
        likely["reversed_deg"] = other_deg - 2 * max_zero_deg, other_deg + 2 * max_zero_deg
    return likely


def _station(session: Session, bend_deg: float) -> Step | None:
    """Return the next station of a bend; None where all are done."""
    incline_deg = next_incline_deg(session, bend_deg)
    if incline_deg is None:
        return None
    plan, first = session.setup.plan, not bend_readings(session, bend_deg)
    # The last line is that of the 2005 robot.
    line = station_line(session, bend_deg) or station_line(session, 0.0) or (53.0, 0.0)
    # After three time constants m / C_t, 5 % of a disturbance is left.
    settle_s = 3.0 * line[0] / session.setup.laboratory.gravity_m_s2
    likely, hint = expected_speed(session, bend_deg, incline_deg), ""
    if likely is not None:
        low, high = likely
        hint = f", at about {low:.2f} to {high:.2f} m/s ({3.6 * low:.1f} to {3.6 * high:.1f} km/h)"
    say = (
        f"Incline to about {incline_deg:.1f} deg "
        f"({100 * math.tan(math.radians(incline_deg)):.1f} %). Raise the belt until the robot "
        f"holds its place, or nearly{hint}."
    )
    if first:
        say += (
            f" If the belt carries it off, or it holds only below {MIN_SLIP_M_S:g} m/s, make it "
            "steeper. Let it settle. Then type the drift (m/s, + uphill) and the turn (+ to the "
            "left), as 0.01 3deg. If it goes on drifting, type its positions over some 4 s as "
            f"s:m, {EXAMPLE}, or the name of a file that lists them."
        )
    # A misread incline misplaces all later stations, so one far from the wanted incline is queried.
    # The first of a bent robot may have to be much steeper.
    far_deg = 2 * plan.incline_step_deg
    high_deg = TUMBLING_DEG if first and bend_deg else incline_deg + far_deg
    incline, *fields = Reading.questions("incline_deg", "belt_speed_m_s", "drift_m_s", "turned_deg")
    return Step(
        f"{_station_key(bend_deg)}{incline_deg:.2f} deg",
        "station",
        say,
        (replace(incline, likely=(incline_deg - far_deg, high_deg)), *fields),
        bend_deg,
        incline_deg,
        settle_s,
    )


def _gait_run(session: Session) -> Step | None:
    """Return the next gait run of the plan; None where all are done."""
    plan = session.setup.plan
    crawls = [(run.alpha_rad, run.beta_rad, run.omega_rad_s) for run in session.kept_crawls]
    for number, gait in enumerate(plan.gaits, 1):
        planned = gait.alpha_rad, gait.beta_rad, gait.omega_rad_s
        # A board's clock is wrong by 5 % at most.
        runs = sum(np.allclose(crawl, planned, rtol=0.05) for crawl in crawls)
        key = f"gait {number}.{runs + 1}"
        if runs >= plan.gait_runs or key in session.skipped:
            continue
        # On a floor the runs go there and back in turn, so that its slope cancels.
        way, where = "level", "level ground"
        if plan.on == "floor":
            way = WAYS[runs % 2]
            where = f"along the line of the pushes, {way.upper()}"
        duration, distance = GaitRun.questions("duration_s", "distance_m")
        timed, marks = [run.distance_m for run in session.kept_of("gait")], "two marks"
        if timed and timed[-1]:
            distance = replace(distance, usual=timed[-1])
            marks = f"the marks, {timed[-1]:g} m apart as before unless you type it"
        say = (
            f"Gait run {runs + 1} of {plan.gait_runs}, {where}, of the same surface: "
            f"{gait_name(gait)}. Once it goes steadily, film it from above for two cycles at "
            f"least, or time it between {marks}. "
            f"{too_fast_text(gait, driving(session.setup, HOBBY))}"
        ).rstrip()
        cells: Values = {
            "alpha_deg": math.degrees(gait.alpha_rad),
            "beta_deg": math.degrees(gait.beta_rad),
            "omega_rad_s": gait.omega_rad_s,
            "way": way,
        }
        return Step(key, "gait", say, (duration, distance), gait=gait, cells=cells)
    return None
