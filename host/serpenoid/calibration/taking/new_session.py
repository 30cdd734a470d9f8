"""A new session's folder: what is asked before the first reading, and session.toml in words."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path
from typing import Any

from ...model.bends import FEWEST_LINKS
from ...model.errors import BadInput, RecordingFailed
from ...model.files import write_text
from ...model.gait import Gait
from ...model.robot import Robot
from ..kinds.declaration import Field
from ..kinds.instruments import Uncertainty
from ..kinds.rows import READING_COLUMNS
from ..session import Procedure, Setup
from ..session_file import load_setup
from ..session_rows import EVENT_COLUMNS
from .journal import csv_line, utc_now

SAME = 0.005
TEXT = """\
# How this session was set up. Changes are made by `serpenoid calibrate amend`: those of instruments
# and plan hold from then on, so that each reading keeps those it was taken with; those of robot and
# laboratory correct what was mistyped, for all of the session. Another robot is another session.
format = 2
name = {name}
program = {program}
created_utc = {created}

[provenance]
kind = {kind}          # measured, or simulated
source = {source}
note = {note}

[robot]
links = {links}
link_mass_kg = {link_mass_kg}       # the whole robot's mass, cables and all, over the links
link_length_m = {link_length_m}      # joint to joint
weighed = {weighed}          # false: the mass is an assumption, asked for when readings are taken
{wheels}{plug}
[laboratory]
surface = {surface}    # what the wheels roll on; friction holds for it alone
place = {place}
people = {people}
gravity_m_s2 = {gravity_m_s2}

[instruments]               # standard deviations; steps of d give d / sqrt(12)
incline_sigma_deg = {incline_sigma_deg}
incline_zero_sigma_deg = {incline_zero_sigma_deg}    # where it is not measured by reversal
belt_speed_sigma_m_s = {belt_speed_sigma_m_s}
lambda_sigma_deg = {lambda_sigma_deg}          # of one bend, protractor and joints
belt_scale_sigma_percent = {belt_scale_sigma_percent}  # of the speed that the treadmill shows
mass_sigma_percent = {mass_sigma_percent}        # of the robot's mass
joint_sigma_deg = {joint_sigma_deg}           # of each joint about straight, once aligned
incline_step_percent = {incline_step_percent}      # what the treadmill can be set to
belt_speed_step_m_s = {belt_speed_step_m_s}
belt_speed_least_m_s = {belt_speed_least_m_s}
distance_sigma_m = {distance_sigma_m}        # of a gait run: tape and marks; stopwatch
time_sigma_s = {time_sigma_s}
film_scale_sigma_percent = {film_scale_sigma_percent}  # of lengths in a film of pushes
push_time_sigma_s = {push_time_sigma_s}         # of a push or a slide timed by hand
floor_slope_sigma_deg = {floor_slope_sigma_deg}     # of the floor, before both ways tell it

[plan]
on = {on}              # treadmill; or floor: pushes instead of stations
push_lambda_deg = {push_lambda_deg}
pushes = {pushes}                  # in each of these bends, half of them either way
lambda_deg = {lambda_deg}    # 7.5 as in 2005; 15 and 30 tell cn three to ten times better
incline_start_deg = {incline_start_deg}
incline_step_deg = {incline_step_deg}
belt_speed_max_m_s = {belt_speed_max_m_s}
bend = {bend}             # balanced; or zigzag, for a robot that is guided on the belt
ratchet = {ratchet}             # true: straight stations also facing up, where wheels roll back
gait_runs = {gait_runs}              # of each gait, on level ground of the same surface
gaits = [{gaits}]
"""


# What `calibrate new` asks: words, the links, then numbers, where a bare one out of the range that
# is likely is asked about.
WORDS = {
    "surface": "what the wheels roll on (the belt's or the floor's surface)",
    "place": "where",
    "people": "who measures",
}
NUMBERS = (
    Field(
        "mass_kg",
        "mass of the whole robot as it crawls (kg, or 480 g)",
        "mass",
        0.001,
        1000.0,
        (0.02, 20.0),
    ),
    Field(
        "link_length_m",
        "length of a link, joint to joint (m, or 76 mm)",
        "length",
        0.001,
        10.0,
        (0.01, 1.0),
    ),
    Field(
        "supply_v",
        "servos: voltage at their plug while they move (V, or later)",
        "voltage",
        1.0,
        60.0,
        (4.0, 15.0),
    ),
    Field(
        "incline_step_deg_shown", "inclinometer: smallest step it shows (deg)", "angle", 0.0001, 5.0
    ),
    Field(
        "incline_step_percent",
        "treadmill: smallest step of its incline (% or deg)",
        "grade",
        0.001,
        20.0,
    ),
    Field(
        "belt_speed_step_km_h",
        "belt: smallest step it can be set to (km/h, m/s or mph)",
        "belt",
        0.0001,
        5.0,
    ),
    Field(
        "belt_speed_least_km_h", "belt: least speed above 0 (km/h, m/s or mph)", "belt", 0.0, 10.0
    ),
)
ROBOT = 3  # of the numbers: those that a floor needs, too
WHEELS = Field(
    "wheels_kg", "mass of all wheels together (kg, or 36 g)", "mass", 0.0, 100.0, (0.001, 2.0)
)
# At the ends joints stand at twice this: it leaves 6 deg of 90 to trims and steering.
STEEPEST_PUSH_DEG = 42.0
PUSHES, CRAWL_RUNS = 8, 2  # on a floor, in each bend; of each gait, there and back
# On a floor: away from the cliff, far from each other, and little moved by a slope.
CRAWLS = tuple(
    Gait(math.radians(alpha), math.radians(beta), 2 * math.pi * hz)
    for alpha, beta, hz in ((70, 60, 0.8), (80, 75, 0.45))
)


def default_setup(name: str) -> Setup:
    """Return the set-up that is proposed: the 2005 robot, a home treadmill, bends to 30 degrees."""
    deg = math.radians
    rates = [2 * math.pi * hz for hz in (0.25, 0.5, 1.0)]
    return Setup(
        name=name,
        kind="measured",
        source="taken with `serpenoid calibrate`",
        note="none",
        robot=Robot(6, 0.0756, 0.076),
        procedure=Procedure(
            lambda_rad=(0.0, deg(7.5), deg(15.0), deg(30.0)),
            incline_start_rad=deg(2.0),
            incline_step_rad=deg(0.3),
            belt_speed_max_m_s=1.0,
            gravity_m_s2=9.80665,
            gaits=tuple(Gait(deg(70), deg(75), rate) for rate in rates),
            gait_runs=3,
            bend="balanced",
            push_lambda_rad=(0.0, deg(20.0), deg(STEEPEST_PUSH_DEG)),
            pushes=PUSHES,
        ),
        uncertainty=Uncertainty(deg(0.03), deg(0.1), 0.01, deg(0.5), 0.02, 0.005, deg(0.5)),
        surface="not said",
        place="not said",
        people="not said",
    )


def on_place(plan: Procedure, place: str) -> Procedure:
    """Return a plan to be carried out at a place; on a floor with crawls of its own."""
    if place != "floor":
        return replace(plan, on=place)
    return replace(plan, on=place, gaits=CRAWLS, gait_runs=CRAWL_RUNS)


def answered(setup: Setup, answers: Mapping[str, Any]) -> Setup:
    """Return a set-up with the answers of `calibrate new` put in; raises BadInput."""
    given = {k: v for k, v in answers.items() if v is not None}
    words = {k: given[k] for k in ("surface", "place", "people") if k in given}
    links = int(given.get("links", setup.robot.links))
    mass_kg = given.get("mass_kg", links * setup.robot.link_mass_kg)
    robot = Robot(links, mass_kg / links, given.get("link_length_m", setup.robot.link_length_m))
    if links < FEWEST_LINKS:  # they have no balanced bend
        setup = replace(setup, procedure=replace(setup.procedure, bend="zigzag"))
    if "wheels_kg" in given:
        setup = replace(setup, floor=replace(setup.floor, wheels_kg=given["wheels_kg"]))
    setup = replace(setup, supply_v=given.get("supply_v", setup.supply_v))
    unsure, steps = setup.uncertainty, setup.treadmill
    if "incline_step_deg_shown" in given:
        sigma_rad = math.radians(given["incline_step_deg_shown"]) / math.sqrt(12)
        unsure = replace(unsure, incline_sigma_rad=sigma_rad)
    if "incline_step_percent" in given:
        steps = replace(steps, incline_step_rad=given["incline_step_percent"] / 100)
    if "belt_speed_step_km_h" in given:
        step_m_s = given["belt_speed_step_km_h"] / 3.6
        steps = replace(steps, belt_step_m_s=step_m_s)
        # Rounding of the display, and as much again for the drift that a person reads off.
        unsure = replace(unsure, belt_speed_sigma_m_s=math.hypot(step_m_s / math.sqrt(12), 0.008))
    if "belt_speed_least_km_h" in given:
        steps = replace(steps, belt_least_m_s=given["belt_speed_least_km_h"] / 3.6)
    return replace(setup, robot=robot, uncertainty=unsure, treadmill=steps, **words)


def template_setup(path: str | Path | None, name: str) -> Setup:
    """Return the set-up of another session, or the proposed one; raises BadInput."""
    if path is None:
        return default_setup(name)
    found = load_setup(path)
    words = {k: getattr(found, k) or "not said" for k in ("surface", "place", "people")}
    proposed = default_setup(name)
    plan = found.procedure
    if found.robot.links >= FEWEST_LINKS:
        plan = replace(plan, bend="balanced")
    if not plan.gaits:
        plan = replace(plan, gaits=proposed.procedure.gaits)
    kind = {} if found.kind != "regenerated" else {"kind": "measured"}
    said = {"source": proposed.source, "note": proposed.note}
    return replace(found, name=name, procedure=plan, **words, **kind, **said)


def setup_text(setup: Setup) -> str:
    """Return session.toml."""
    plan, unsure, steps, watch = (
        setup.procedure,
        setup.uncertainty,
        setup.treadmill,
        setup.stopwatch,
    )
    gaits = [
        f"{{ alpha_deg = {_number(math.degrees(g.alpha_rad))}, "
        f"beta_deg = {_number(math.degrees(g.beta_rad))}, "
        f"omega_rad_s = {_number(g.omega_rad_s)} }}"
        for g in plan.gaits
    ]
    words = ("name", "kind", "source", "note", "surface", "place", "people")
    return TEXT.format(
        **{word: quoted(getattr(setup, word)) for word in words},
        program=quoted(f"serpenoid {version('serpenoid')}"),
        created=quoted(utc_now()),
        links=setup.robot.links,
        weighed=str(setup.weighed).lower(),
        link_mass_kg=_number(setup.robot.link_mass_kg),
        link_length_m=_number(setup.robot.link_length_m),
        gravity_m_s2=_number(plan.gravity_m_s2),
        incline_sigma_deg=_degrees(unsure.incline_sigma_rad),
        incline_zero_sigma_deg=_degrees(unsure.incline_zero_sigma_rad),
        belt_speed_sigma_m_s=_number(unsure.belt_speed_sigma_m_s),
        lambda_sigma_deg=_degrees(unsure.lambda_sigma_rad),
        belt_scale_sigma_percent=_number(100 * unsure.belt_scale_sigma),
        mass_sigma_percent=_number(100 * unsure.mass_sigma),
        joint_sigma_deg=_degrees(unsure.joint_sigma_rad),
        incline_step_percent=_number(100 * steps.incline_step_rad),
        belt_speed_step_m_s=_number(steps.belt_step_m_s),
        belt_speed_least_m_s=_number(steps.belt_least_m_s),
        distance_sigma_m=_number(watch.distance_sigma_m),
        time_sigma_s=_number(watch.time_sigma_s),
        lambda_deg=[float(_degrees(x)) for x in plan.lambda_rad],
        incline_start_deg=_degrees(plan.incline_start_rad),
        incline_step_deg=_degrees(plan.incline_step_rad),
        belt_speed_max_m_s=_number(plan.belt_speed_max_m_s),
        gait_runs=plan.gait_runs,
        bend=quoted(plan.bend),
        wheels=""
        if setup.floor.wheels_kg is None
        else f"wheels_kg = {_number(setup.floor.wheels_kg)}          # all wheels together\n",
        plug="".join(
            f"{name} = {_number(value)}{words}\n"
            for name, value, words in (
                ("supply_v", setup.supply_v, "              # at the servos' plug, as they move"),
                ("frame_ms", setup.frame_s and 1e3 * setup.frame_s, "              # of the board"),
                (
                    "tag_mm",
                    setup.tag_side_m and 1e3 * setup.tag_side_m,
                    "    # of its printed tags",
                ),
            )
            if value is not None
        ),
        film_scale_sigma_percent=_number(100 * setup.floor.film_scale_sigma),
        push_time_sigma_s=_number(setup.floor.push_time_sigma_s),
        floor_slope_sigma_deg=_degrees(setup.floor.slope_sigma_rad),
        on=quoted(plan.on),
        pushes=plan.pushes,
        push_lambda_deg=[float(_degrees(x)) for x in plan.push_lambda_rad],
        ratchet=str(plan.ratchet).lower(),
        gaits="".join(f"\n  {gait}," for gait in gaits) + ("\n" if gaits else ""),
    )


def create_session(folder: str | Path, setup: Setup) -> Path:
    """Make a session's folder; session.toml comes last, so that a folder with one is whole.

    Raises BadInput where there is a session already, RecordingFailed where it cannot be written.
    """
    folder = Path(folder)
    refuse_existing(folder)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name, columns in (("readings.csv", READING_COLUMNS), ("events.csv", EVENT_COLUMNS)):
            write_text(folder / name, csv_line(list(columns)))
        write_text(folder / "session.toml", setup_text(setup))
    except OSError as error:
        raise RecordingFailed(f"{folder}: {error.strerror}; choose another folder") from error
    return folder


def refuse_existing(folder: Path) -> None:
    """Raise BadInput where there is a session already."""
    if (folder / "session.toml").exists():
        raise BadInput(
            f"{folder}: there is a session already, and nothing overwrites it; go on with "
            f"`serpenoid calibrate {folder}`, or give the new one another name"
        )


def identity_differences(session: Setup, wanted: Setup) -> list[str]:
    """Return what keeps two set-ups from being one session, a line each: robot, mass, surface.

    Numbers may differ by SAME: nobody weighs the same robot twice to the same figures.
    """
    lines = []
    for name, a, b in (
        ("links", session.robot.links, wanted.robot.links),
        ("link_mass_kg", session.robot.link_mass_kg, wanted.robot.link_mass_kg),
        ("link_length_m", session.robot.link_length_m, wanted.robot.link_length_m),
        ("surface", session.surface, wanted.surface),
        ("gravity_m_s2", session.procedure.gravity_m_s2, wanted.procedure.gravity_m_s2),
    ):
        same = abs(a - b) <= SAME * a if isinstance(a, float) and isinstance(b, float) else a == b
        if not same:
            lines.append(f"{name}: the session has {a!r}, this has {b!r}")
    return lines


def quoted(text: str) -> str:
    """Return text as a TOML string."""
    return json.dumps("".join(c for c in text if c != "\x7f"), ensure_ascii=False)


def _number(value: float) -> str:
    text = f"{value:.10g}"
    return text if any(c in text for c in ".en") else f"{text}.0"


def _degrees(value_rad: float) -> str:
    return _number(float(f"{math.degrees(value_rad):.8g}"))
