"""The procedure: from a session's readings to the next step. Pure; nothing is asked or shown here.

Inclinometer zero by reversal; straight, stations from the first incline up to the top belt speed;
each bend with its protractor check, then its stations; the zero again; gait runs. Where a session
stands follows from its rows alone, so that resuming is nothing special.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Set
from dataclasses import replace

from ..servos.catalogue import HOBBY
from ..servos.speed_limit import too_fast_text
from ..session.crawls import driving
from ..session.declaration import Cells, Field, Range, Values
from ..session.gait_run import RUN_WAYS, GaitRun
from ..session.session import Session, belt_checks
from ..session.settings import Setup
from ..session.station import LEAST_SLIP_M_S, BeltCheck, Reading, ZeroReading
from ..session.track import drifts
from .bends import bend_step
from .expected import (
    STRAIGHT,
    Series,
    expected_speed,
    law_sine,
    line_of,
    of_series,
    series_of,
    series_of_pushes,
    shown_bend,
    slowing_deg,
)
from .floor_procedure import push_name, push_pose, push_step
from .steps import Doubts, Step

ZERO_BEFORE, ZERO_AFTER, BELT_CHECK = "zero before", "zero after", "belt check"
_ZERO = Step(
    "",
    "zero",
    "Inclinometer zero. Lay it on one spot of the treadmill, read it; turn it end for end on the "
    "same spot, read it again (with the sign it shows).",
    ZeroReading.asked(),
)
_BELT = Step(
    "",
    "belt",
    "Belt check, robot off the belt: mark the belt's edge, run it at a speed that you used much, "
    "and time ten turns or more. The way is turns times the belt's length.",
    BeltCheck.asked(),
)
MOST_DEG = 12.0  # of incline: the snake starts to tumble, or the wheels to slide
MOST_ZERO_DEG = 0.5  # beyond it an inclinometer's sign was forgotten, or it is not one to use
SETTLE_TIMES = 3.0  # of m / C_t, after which 5 % of a disturbance is left
_DONE = Step("done", "done", "all of the plan is done")
SERIES = 6  # stations of a bend from rest to the top speed
FEWEST = 3  # stations of a bend before the top speed may end it
REASON = "7.5 deg tells cn to 35 %, 15 deg to 10 %, 30 deg to 4 %"


def step_in_words(key: str) -> str:
    """Return a step's key in words, such as `station 7.5 2.60` of a station."""
    what, *numbers = key.split()
    if what == "pushes" and numbers[0] != "straight":
        return f"pushes, bend {numbers[0]} deg"
    if what != "station" or len(numbers) != 2:
        return key
    bend, incline = numbers
    pose = "straight" if bend == "0" else f"bend {bend} deg"
    return f"station at {incline} deg, {pose}"


def next_step(session: Session, posed_deg: float | None = None) -> Step:
    """Return what to do next; kind "done" when nothing is left.

    posed_deg: how the robot lies now, the plan's bend in degrees; None when that is not known, as
    at the start.
    """
    steps = (step for _, _, step in _parts(session))
    step = next(filter(None, steps), _DONE)
    if step is _DONE and (skipped := len(session.skipped)):
        return replace(_DONE, say=f"{_DONE.say}, but for {skipped} left out")
    if step.series is None:
        return step
    setup, series = session.setup, step.series
    shown_rad = shown_bend(session, series.lambda_rad)
    if posed_deg != step.lambda_deg or shown_rad is None:
        return (push_pose if setup.plan.on == "floor" else _pose)(setup, series)
    shown = {"lambda_deg": round(math.degrees(shown_rad), 4)}
    return replace(step, cells=shown | step.cells)


def progress(session: Session) -> list[tuple[str, str]]:
    """Return the parts of the plan and how far each is, in words."""
    return [(name, state) for name, state, _ in _parts(session)]


def _parts(session: Session) -> Iterator[tuple[str, str, Step | None]]:
    """Yield the parts of the plan: name, how far it is, and its next reading, None where none is.

    Whatever pose a reading needs comes before it.
    """
    plan, skipped = session.setup.plan, session.skipped
    if plan.on == "floor":
        for series in series_of_pushes(plan):
            done = len(of_series(session, series))
            step = None if series.key in skipped else push_step(session, series)
            rest = ", the rest left out" if step is None and done < plan.pushes else ""
            yield push_name(series), f"{done} of {plan.pushes}{rest}", step
    else:
        before, after = (_zero_read(session, side) for side in (True, False))
        yield _check(ZERO_BEFORE, before, _ZERO, skipped if not session.kept else {ZERO_BEFORE})
        for series in series_of(plan):
            step = None if series.key in skipped else _station(session, series)
            name = f"{series.key} deg" if series.lambda_rad else series.name
            held = len(of_series(session, series))
            state = "more to come" if step else "done" if held else "left out"
            yield name, f"{held} stations, {state}", step
        none = {ZERO_AFTER, BELT_CHECK}
        yield _check(ZERO_AFTER, after, _ZERO, skipped if session.kept else none)
        checked = bool(belt_checks(session))
        yield _check(BELT_CHECK, checked, _BELT, skipped if session.kept else none)
    runs = f"{len(session.kept_crawls)} of {len(plan.gaits) * plan.gait_runs}"
    yield "gait runs", runs, _gait_step(session)


def _check(key: str, done: bool, step: Step, skipped: Set[str]) -> tuple[str, str, Step | None]:
    left_out = done or key in skipped
    return key, "done" if done else "open", None if left_out else replace(step, key=key)


def _zero_read(session: Session, before: bool) -> bool:
    return any(zero.before is before for zero in session.kept_of("zero"))


def next_incline_deg(session: Session, series: Series) -> float | None:
    """Return the incline of a series' next station, None when it needs no more.

    Inclines rise by the plan's step, or by more where that would change the speed by less than a
    sixth of the top speed; a bend is done when its next station would pass the top speed, or the
    incline at which the snake tumbles. After a fast first station comes a slower one, or half as
    much slower where that could not be held: dry friction shows at low speeds.
    """
    plan = session.setup.plan
    stations = of_series(session, series)
    prefix = _station_key(series)
    passed = [float(k.removeprefix(prefix)) for k in session.skipped if k.startswith(prefix)]
    tried = [*(math.degrees(r.incline_rad) for r in stations), *passed]
    # At least what the treadmill can be raised by, or its rounding could stay below for ever.
    step_deg = math.degrees(max(plan.incline_step_rad, session.setup.instruments.incline_step_rad))
    if len(stations) == 1:
        first_deg = math.degrees(stations[0].incline_rad)
        less_deg = slowing_deg(session.setup, stations[0]) / 2 ** sum(p < first_deg for p in passed)
        if less_deg > step_deg / 2:
            return round(first_deg - less_deg, 3)
    first_deg = _first_incline_deg(session, series)
    found_deg = max(tried) + step_deg if tried else first_deg
    line = line_of(session, series)
    top_m_s = max((r.slip_speed_m_s for r in stations), default=0.0)
    if line is not None and len(stations) >= FEWEST - 1:
        faster = line.sine_at(top_m_s + plan.belt_speed_max_m_s / SERIES)
        found_deg = max(found_deg, math.degrees(math.asin(min(faster, 1.0))))
    next_m_s = line.at(math.sin(math.radians(found_deg)))[0] if line is not None else 0.0
    if len(stations) >= FEWEST and next_m_s > plan.belt_speed_max_m_s:
        return None
    done = top_m_s >= plan.belt_speed_max_m_s or found_deg > MOST_DEG
    return None if done else round(found_deg, 3)


def _station_key(series: Series) -> str:
    return f"station {series.bend_deg:g} "


def _first_incline_deg(session: Session, series: Series) -> float:
    """Return where a series begins.

    The steepest of: the plan's start, where lesser bends first held, and where the frictions so far
    let this one hold at a sixth of the top speed.
    """
    plan, lambda_rad = session.setup.plan, series.lambda_rad
    lesser = [of_series(session, Series(x)) for x in plan.lambda_rad if x < lambda_rad]
    held = [min(r.incline_rad for r in stations) for stations in lesser if stations]
    law = law_sine(session, lambda_rad, plan.belt_speed_max_m_s / SERIES)
    law_deg = min(math.degrees(math.asin(min(law, 1.0))), MOST_DEG)
    return max(law_deg, *map(math.degrees, [plan.incline_start_rad, *held]))


def doubts(session: Session, step: Step, cells: Cells) -> Doubts:
    """Return the fields whose numbers are not where they were expected, and where that is.

    A station's belt speed is judged at the incline that was typed, with the drift taken off.
    """
    doubtful = []
    for field in step.fields:
        if field.column not in cells:
            continue
        value, likely = float(cells[field.column]), field.likely
        if field.column == "belt_speed_m_s" and step.kind == "station":
            likely = likely_belt(session, step, cells)
        if field.column == "reversed_deg":
            likely = _likely_reversed(cells)
        if field.column in ("drift_m_s", "waited_s") and cells.get("places"):
            continue  # of a short reading: any drift will do, and it does not wait
        if likely is not None and not likely[0] <= value <= likely[1]:
            doubtful.append((field, likely))
        elif field.column == "belt_speed_m_s" and step.kind == "station":
            doubtful += _too_slow(field, value, cells)
    return doubtful


def _too_slow(field: Field, belt_m_s: float, cells: Cells) -> Doubts:
    """Return a station's belt speed where it is too slow for the law to hold."""
    least_m_s = LEAST_SLIP_M_S + float(cells.get("drift_m_s", 0.0))
    if belt_m_s >= least_m_s:
        return []
    why = (
        f"slower than {LEAST_SLIP_M_S:g} m/s past the robot, steering shakes wheels loose and "
        "friction is not that of the law: skip this one, the next is steeper"
    )
    return [(replace(field, why=why), (least_m_s, field.high))]


def _likely_reversed(cells: Cells) -> Range:
    """Return what an inclinometer turned end for end shows if its zero is no more than usual."""
    shown_deg = float(cells["incline_deg"])
    return -shown_deg - 2 * MOST_ZERO_DEG, -shown_deg + 2 * MOST_ZERO_DEG


def likely_belt(session: Session, step: Step, cells: Cells) -> Range | None:
    """Return the belt speeds expected at the incline and drift typed so far; None if unknown."""
    incline_rad = math.radians(float(cells.get("incline_deg", step.incline_deg)))
    places = str(cells.get("places", ""))
    if places:  # as steep as where it would hold its place at this speed
        _, change_m_s, duration_s = drifts(places)
        incline_rad += change_m_s / duration_s / session.setup.laboratory.gravity_m_s2
    series = Series(math.radians(step.lambda_deg))
    range_m_s = expected_speed(session, series, incline_rad)
    if range_m_s is None:
        return None
    drift_m_s = float(cells.get("drift_m_s", 0.0))
    step_m_s = session.setup.instruments.belt_speed_step_m_s
    return max(range_m_s[0] + drift_m_s - step_m_s, 0.0), range_m_s[1] + drift_m_s + step_m_s


def settle_s(session: Session, series: Series = STRAIGHT) -> float:
    """Return how long a station takes to settle: 3 m / A, by the readings so far or the paper's."""
    line = line_of(session, series) or line_of(session, STRAIGHT)
    mass_kg = session.setup.robot.links * session.setup.robot.link_mass_kg
    # Where the balance is m g sin(gamma) = A v + B, the line's slope is m g / A.
    if line is None:
        return SETTLE_TIMES * mass_kg / 0.084
    return SETTLE_TIMES * line.slope / session.setup.laboratory.gravity_m_s2


def _pose(setup: Setup, series: Series) -> Step:
    if not series.lambda_rad:
        return Step(
            "straight",
            "straight",
            "Robot straight, on the belt, head downhill, the belt running uphill.",
        )
    return bend_step(series.key, setup, series.bend_deg, f"({REASON}.)")


def _station(session: Session, series: Series) -> Step | None:
    """Return the next station of a series, its bend still to be told; None where all are done."""
    incline_deg = next_incline_deg(session, series)
    if incline_deg is None:
        return None
    wait_s = settle_s(session, series)
    step_deg = math.degrees(session.setup.plan.incline_step_rad)
    likely = expected_speed(session, series, math.radians(incline_deg))
    hint = "" if likely is None else f", about {belt_range(likely)}"
    grade = 100 * math.tan(math.radians(incline_deg))
    say = (
        f"Incline to about {incline_deg:.1f} deg ({grade:.1f} %). Raise the belt until the robot "
        f"holds its place{hint}, or nearly. Type the belt's speed then, and let it settle "
        f"{wait_s:.0f} s; or film it for some 4 s, and type its places."
    )
    first = not of_series(session, series)
    if first:
        say += " Steeper, if the belt carries it off at any speed."
    # A misread first station leads its whole series astray: straight, a far one is asked about.
    steep = first and series.lambda_rad > 0
    near_deg = (incline_deg - 2 * step_deg, MOST_DEG if steep else incline_deg + 2 * step_deg)
    shown, belt, waited = Reading.asked("incline_deg", "belt_speed_m_s", "waited_s")
    cells: Values = {"bend": series.bend} if series.lambda_rad else {}
    return Step(
        f"{_station_key(series)}{incline_deg:.2f}",
        "station",
        say,
        (
            replace(shown, likely=near_deg),
            replace(belt, likely=likely),
            *Reading.asked("turned_deg", "drift_m_s"),
            replace(waited, likely=(wait_s / 2, math.inf), why=f"let it settle {wait_s:.0f} s"),
        ),
        series.bend_deg,
        incline_deg,
        wait_s,
        bend=series.bend,
        cells=cells,
        series=series,
    )


def belt_range(likely_m_s: Range) -> str:
    """Return a range of belt speeds in both units that treadmills show."""
    low, high = likely_m_s
    return f"{low:.2f} to {high:.2f} m/s ({3.6 * low:.1f} to {3.6 * high:.1f} km/h)"


def _gait_step(session: Session) -> Step | None:
    plan, skipped = session.setup.plan, session.skipped
    for number, gait in enumerate(plan.gaits, 1):
        runs = [
            r
            for r in session.kept_crawls
            if abs(r.alpha_rad - gait.alpha_rad) < 1e-3
            and abs(r.beta_rad - gait.beta_rad) < 1e-3
            and abs(r.omega_rad_s / gait.omega_rad_s - 1) < 0.05
        ]
        key = f"gait {number}.{len(runs) + 1}"
        if len(runs) >= plan.gait_runs or key in skipped or f"gait {number}" in skipped:
            continue
        alpha, beta = math.degrees(gait.alpha_rad), math.degrees(gait.beta_rad)
        # On a floor there and back, so that its slope cancels.
        way = RUN_WAYS[1 + len(runs) % 2] if plan.on == "floor" else ""
        where = f"along the line of the pushes, {way.upper()}" if way else "level ground"
        say = (
            f"Gait run {len(runs) + 1} of {plan.gait_runs}, {where}, of the same surface: "
            f"alpha {alpha:g} deg, beta {beta:g} deg, {gait.omega_rad_s / (2 * math.pi):.3g} Hz. "
            "Once it goes steadily, film it from above for two cycles at least, or time it between "
            "two marks."
        )
        too_fast = too_fast_text(gait, driving(session.setup, HOBBY))
        say = f"{say} {too_fast}".rstrip()
        fields = GaitRun.asked("distance_m", "duration_s")
        cells: Values = {
            "alpha_deg": round(alpha, 6),
            "beta_deg": round(beta, 6),
            "omega_rad_s": gait.omega_rad_s,
            **({"way": way} if way else {}),
        }
        return Step(key, "gait", say, fields, gait=gait, cells=cells)
    return None
