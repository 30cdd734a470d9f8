"""A new session's folder: what is asked before the first reading, and session.toml in words."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from importlib.metadata import version
from operator import attrgetter
from pathlib import Path
from typing import Any

from ..base.errors import BadInput, RecordingFailed
from ..base.files import write_text
from ..model.bends import FEWEST_LINKS
from ..model.gait import Gait
from ..model.robot import Robot
from ..session.declaration import Field, in_si
from ..session.folder import load_setup
from ..session.instruments import Uncertainty
from ..session.journal import csv_line, utc_now
from ..session.kinds import READING_COLUMNS
from ..session.rows import EVENT_COLUMNS
from ..session.session import Procedure, Setup
from ..session.settings import SETTINGS, changed, quoted

SAME = 0.005
LATER = "later"  # answers for what nobody has measured yet
NOT_SAID = "not said"
TEXT = """\
# How this session was set up. Changes are made by `serpenoid calibrate amend`: those of the plan
# hold from then on; those of robot and laboratory correct what was mistyped, for the whole session;
# instruments change before the first reading. Another robot or instrument is another session.
format = 2
name = {name}
program = {program}
created_utc = {created}
"""


@dataclass(frozen=True)
class Question:
    """A number that `calibrate new` asks for; one that is not likely is asked about.

    field: its attribute is the path of the setting that holds the answer. usual: what Enter takes,
    with the setting's value in SI put in, and how many of its unit are one in SI. on: where it is
    asked; anywhere if empty. values: returns what follows from the answer by the paths of settings,
    where that is not one setting.
    """

    field: Field
    usual: str = LATER
    per_si: float = 1.0
    on: str = ""
    values: Callable[[Setup, float], dict[str, Any]] | None = None

    def usual_of(self, setup: Setup) -> str:
        """Return what Enter takes."""
        if self.usual == LATER:
            return LATER
        return self.usual.format(self.per_si * attrgetter(self.field.attribute)(setup))

    def answered(self, setup: Setup, answer: float) -> Setup:
        """Return the set-up with an answer put in; raises BadInput."""
        if self.values is not None:
            return changed(setup, self.values(setup, answer))
        return changed(setup, {self.field.attribute: in_si(self.field.column, answer)})


def _belt_step(setup: Setup, step_km_h: float) -> dict[str, Any]:
    step_m_s = step_km_h / 3.6
    # Rounding of the display, and as much again for the drift that a person reads off.
    sigma_m_s = math.hypot(step_m_s / math.sqrt(12), 0.008)
    return {"treadmill.belt_step_m_s": step_m_s, "uncertainty.belt_speed_sigma_m_s": sigma_m_s}


# What `calibrate new` asks: words, the links, then numbers.
WORDS = {
    "surface": "what the wheels roll on (the belt's or the floor's surface)",
    "place": "where",
    "people": "who measures",
}
MASS = Question(
    Field(
        "mass_kg",
        "mass of the whole robot as it crawls (kg, or 480 g)",
        0.001,
        1000.0,
        (0.02, 20.0),
    ),
    values=lambda _setup, mass_kg: {"robot.mass_kg": mass_kg},
)
LENGTH = Question(
    Field(
        "link_length_m",
        "length of a link, joint to joint (m, or 76 mm)",
        0.001,
        10.0,
        (0.01, 1.0),
        attribute="robot.link_length_m",
    ),
    "{:.6g} mm",
    1000.0,
)
QUESTIONS = (
    MASS,
    LENGTH,
    Question(
        Field(
            "supply_v",
            "servos: voltage at their plug while they move (V, or later)",
            1.0,
            60.0,
            (4.0, 15.0),
            attribute="supply_v",
        )
    ),
    Question(
        Field(
            "wheels_kg",
            "mass of all wheels together (kg, or 36 g)",
            0.0,
            100.0,
            (0.001, 2.0),
            attribute="floor.wheels_kg",
        ),
        on="floor",
    ),
    Question(
        Field(
            "shown_step_deg",
            "inclinometer: smallest step it shows (deg)",
            0.0001,
            5.0,
            attribute="uncertainty.incline_sigma_rad",
        ),
        "{:.2g}",
        math.degrees(math.sqrt(12)),
        "treadmill",
        lambda setup, step_deg: {
            "uncertainty.incline_sigma_rad": math.radians(step_deg) / math.sqrt(12)
        },
    ),
    Question(
        Field(
            "incline_step_percent",
            "treadmill: smallest step of its incline (% or deg)",
            0.001,
            20.0,
            attribute="treadmill.incline_step_rad",
        ),
        "{:.3g} %",
        100.0,
        "treadmill",
    ),
    Question(
        Field(
            "belt_speed_step_km_h",
            "belt: smallest step it can be set to",
            0.0001,
            5.0,
            attribute="treadmill.belt_step_m_s",
        ),
        "{:.3g} km/h",
        3.6,
        "treadmill",
        _belt_step,
    ),
    Question(
        Field(
            "belt_speed_least_km_h",
            "belt: least speed above 0",
            0.0,
            10.0,
            attribute="treadmill.belt_least_m_s",
        ),
        "{:.3g} km/h",
        3.6,
        "treadmill",
    ),
)
# Zeros of phones and cheap inclinometers are 0.3 to 0.5 deg off. With 0.1 deg assumed, the interval
# of ft0 missed the truth in 40 of 40 sessions of the virtual lab, with 0.5 deg in none.
ASSUMED_ZERO_SIGMA_RAD = math.radians(0.5)
# Each joint about straight, by what sets it; by hand and eye they are 1.5 deg off.
JOINT_SIGMA_RAD = {
    "servos": math.radians(0.5),
    "straightedge": math.radians(0.5),
    "hand": math.radians(1.5),
}
# At the ends joints stand at twice this: it leaves 6 deg of 90 to trims and steering.
STEEPEST_PUSH_DEG = 42.0
PUSHES, CRAWL_RUNS = 8, 2  # on a floor, in each bend; of each gait, there and back
# On a floor: away from the cliff, far from each other, and little moved by a slope. All planned
# gaits are such that a typical hobby servo follows them at 4.8 V.
CRAWLS = tuple(
    Gait(math.radians(alpha), math.radians(beta), 2 * math.pi * hz)
    for alpha, beta, hz in ((70, 60, 0.6), (80, 75, 0.45))
)


def default_setup(name: str) -> Setup:
    """Return the set-up that is proposed: the 2005 robot, a home treadmill, bends to 30 degrees."""
    deg = math.radians
    rates = [2 * math.pi * hz for hz in (0.25, 0.4, 0.6)]
    return Setup(
        name=name,
        kind="measured",
        source="taken with `serpenoid calibrate`",
        note="none",
        robot=Robot(6, 0.0756, 0.076),
        procedure=Procedure(
            lambda_rad=(0.0, deg(7.5), deg(15.0), deg(30.0)),
            incline_start_rad=deg(2.4),
            incline_step_rad=deg(0.3),
            belt_speed_max_m_s=1.0,
            gravity_m_s2=9.80665,
            gaits=tuple(Gait(deg(70), deg(75), rate) for rate in rates),
            gait_runs=3,
            bend="balanced",
            push_lambda_rad=(0.0, deg(20.0), deg(STEEPEST_PUSH_DEG)),
            pushes=PUSHES,
        ),
        uncertainty=Uncertainty(
            incline_sigma_rad=deg(0.03),
            incline_zero_sigma_rad=ASSUMED_ZERO_SIGMA_RAD,
            belt_speed_sigma_m_s=0.01,
            lambda_sigma_rad=deg(0.5),
            belt_scale_sigma=0.02,
            mass_sigma=0.005,
            joint_sigma_rad=JOINT_SIGMA_RAD["servos"],
        ),
        surface=NOT_SAID,
        place=NOT_SAID,
        people=NOT_SAID,
    )


def on_place(plan: Procedure, place: str) -> Procedure:
    """Return a plan to be carried out at a place; on a floor with crawls of its own."""
    if place != "floor":
        return replace(plan, on=place)
    return replace(plan, on=place, gaits=CRAWLS, gait_runs=CRAWL_RUNS)


def answered(setup: Setup, answers: Mapping[str, Any]) -> Setup:
    """Return a set-up with the answers of `calibrate new` put in; raises BadInput."""
    given = {k: v for k, v in answers.items() if v is not None}
    links = int(given.get("links", setup.robot.links))
    if links < FEWEST_LINKS:  # they have no balanced bend
        setup = changed(setup, {"procedure.bend": "zigzag"})
    words = {name: given[name] for name in WORDS if name in given}
    setup = changed(setup, {"robot.links": links, **words})
    if "belt_speed_unit" in given:
        setup = changed(setup, {"belt_speed_unit": given["belt_speed_unit"]})
    if "joints" in given:
        setup = changed(setup, {"uncertainty.joint_sigma_rad": JOINT_SIGMA_RAD[given["joints"]]})
    for question in QUESTIONS:
        if question.field.column in given:
            setup = question.answered(setup, given[question.field.column])
    return setup


def template_setup(path: str | Path | None, name: str) -> Setup:
    """Return the set-up of another session, or the proposed one; raises BadInput."""
    proposed = default_setup(name)
    if path is None:
        return proposed
    other = load_setup(path)
    tools = other.uncertainty
    if other.kind == "regenerated":  # its zero is that of no instrument that the new session has
        tools = replace(tools, incline_zero_sigma_rad=ASSUMED_ZERO_SIGMA_RAD)
    plan = replace(other.procedure, gaits=other.procedure.gaits or proposed.procedure.gaits)
    if other.robot.links >= FEWEST_LINKS:
        plan = replace(plan, bend="balanced")
    return replace(
        other,
        name=name,
        procedure=plan,
        uncertainty=tools,
        kind="measured" if other.kind == "regenerated" else other.kind,
        source=proposed.source,
        note=proposed.note,
        **{word: getattr(other, word) or NOT_SAID for word in WORDS},
    )


def setup_text(setup: Setup) -> str:
    """Return session.toml."""
    head = TEXT.format(
        name=quoted(setup.name),
        program=quoted(f"serpenoid {version('serpenoid')}"),
        created=quoted(utc_now()),
    )
    remarks = {"instruments": "               # standard deviations; steps of d give d / sqrt(12)"}
    tables = [
        f"\n[{name}]{remarks.get(name, '')}\n{''.join(setting.line(setup) for setting in settings)}"
        for name, settings in SETTINGS.items()
    ]
    return head + "".join(tables)


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
    for path in (
        "robot.links",
        "robot.mass_kg",
        "robot.link_length_m",
        "surface",
        "procedure.gravity_m_s2",
    ):
        a, b = (attrgetter(path)(setup) for setup in (session, wanted))
        same = abs(a - b) <= SAME * a if isinstance(a, float) and isinstance(b, float) else a == b
        if not same:
            a, b = (f"{v:.6g}" if isinstance(v, float) else repr(v) for v in (a, b))
            lines.append(f"{path.rpartition('.')[2]}: the session has {a}, this has {b}")
    return lines
