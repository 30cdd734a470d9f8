"""A new session: the set-up that is proposed, what is asked before the first reading, files."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from ..base.errors import BadInput
from ..base.files import write_text
from ..model.bends import MIN_LINKS
from ..model.gait import Gait
from ..session.folder import EVENT_COLUMNS, READING_COLUMNS, read_session
from ..session.journal import PROGRAM, csv_line, utc_now
from ..session.settings import (
    ASSUMED_LINK_KG,
    Instruments,
    Laboratory,
    Plan,
    Provenance,
    RobotTable,
    Setup,
)
from .asking import Asker, Skip, Undo
from .parse_number import bare_unit

LATER = "later"  # answer of people; what is measured later stays empty
QUESTIONS = {  # keys of session.toml that `calibrate new` asks for everywhere, then at a place
    "": ("surface", "links", "link_length_m", "joint_sigma_deg", "mass_kg", "supply_v"),
    "treadmill": (
        "incline_sigma_deg",
        "incline_step_percent",
        "belt_speed_unit",
        "belt_speed_step_m_s",
    ),
    "floor": ("wheels_kg",),
}
SIGMAS_OF_STEP = math.sqrt(12)  # the smallest step of an instrument over its standard deviation
# Zeros of phones and cheap inclinometers are 0.3 to 0.5 deg off. With 0.1 deg assumed, the interval
# of ft0 missed the truth in 40 of 40 sessions of the virtual lab, with 0.5 deg in none.
ASSUMED_ZERO_SIGMA_DEG = 0.5


def default_setup(name: str) -> Setup:
    """Return the set-up that is proposed: the 2005 robot, a home treadmill, bends to 30 degrees."""
    gaits = tuple(Gait.degrees(70, 75, hertz=hz) for hz in (0.25, 0.4, 0.6))
    unsaid = "not said"
    return Setup(
        name,
        Provenance(kind="measured", source="taken with `serpenoid calibrate`", note="none"),
        RobotTable(links=6, mass_kg=6 * ASSUMED_LINK_KG, link_length_m=0.076),
        Laboratory(surface=unsaid, place=unsaid, people=unsaid, gravity_m_s2=9.80665),
        Instruments(
            incline_sigma_deg=0.03,
            incline_zero_sigma_deg=ASSUMED_ZERO_SIGMA_DEG,
            belt_speed_sigma_m_s=0.01,
            lambda_sigma_deg=0.5,
            belt_scale_sigma_percent=2.0,
            mass_sigma_percent=0.5,
            joint_sigma_deg=0.5,
        ),
        Plan(
            lambda_deg=(0.0, 7.5, 15.0, 30.0),
            incline_start_deg=2.4,
            incline_step_deg=0.3,
            belt_speed_max_m_s=1.0,
            gait_runs=2,
            gaits=gaits,
            bend="balanced",
            push_lambda_deg=(0.0, 20.0, 42.0),  # twice 42 leaves 6 deg to trims, steering
        ),
    )


def ask_setup(asker: Asker, setup: Setup, options: Mapping[str, Any], place: str) -> Setup:
    """Return a set-up with options of `calibrate new` and a person's answers; raises Quit."""

    def fill() -> Setup:
        filled = answered(setup, options)
        for key in QUESTIONS[""] + QUESTIONS[place]:
            if options.get(key) is None:
                filled = answered(filled, {key: _answer(asker, filled, key)})
                asker.belt_unit = filled.instruments.belt_speed_unit
        return filled

    while True:
        try:
            return asker.form(fill)
        except Undo:
            asker.say("  ! nothing was asked before this")


def _answer(asker: Asker, setup: Setup, key: str) -> Any:
    """Ask for one key; return its value, "" where it is to be measured later."""
    table = next(table for table in setup.tables.values() if key in table.declared)
    field, usual = table.declared[key], getattr(table, key)
    if not field.is_number:
        usual = "km/h" if field.choices else usual
        return field.check(asker.ask(f"{field.words} [{usual}]: ", usual))
    if key == "incline_sigma_deg":
        usual *= SIGMAS_OF_STEP
    unit = bare_unit(field, asker.belt_unit)
    shown = LATER if field.optional else f"{usual / field.units[unit]:.2g} {unit}".rstrip()
    text = asker.ask(f"{field.words} [{shown}]: ", shown)
    if field.optional and text.lower() == LATER:
        return ""
    values = asker.numbers([field], text)
    try:
        value = float(asker.sure([field], values, lambda _: {key: field.likely})[key])
    except Skip as error:
        raise BadInput("a number in doubt cannot be left out; type it anew, or keep it") from error
    if key == "incline_sigma_deg":
        value /= SIGMAS_OF_STEP
    return field.check(int(value) if value.is_integer() else value)


def on_place(plan: Plan, place: str) -> Plan:
    """Return a plan to be carried out at a place; on a floor with gaits of its own.

    These are away from the sharp drop of speed, far from each other, and little moved by a slope.
    A typical hobby servo follows all planned gaits at 4.8 V.
    """
    if place != "floor":
        return replace(plan, on=place)
    gaits = Gait.degrees(70, 60, hertz=0.6), Gait.degrees(80, 75, hertz=0.45)
    return replace(plan, on=place, gaits=gaits)


def answered(setup: Setup, answers: Mapping[str, Any]) -> Setup:
    """Return a set-up with the answers of `calibrate new` put in; raises BadInput.

    An answer of "" leaves its setting empty.
    """
    values = {key: value for key, value in answers.items() if value is not None}
    if "belt_speed_step_m_s" in values:
        # A reading errs by the display's rounding, and as much by the drift that a person reads.
        rounding_m_s = values["belt_speed_step_m_s"] / SIGMAS_OF_STEP
        values["belt_speed_sigma_m_s"] = math.hypot(rounding_m_s, 0.008)
    if values.get("links", MIN_LINKS) < MIN_LINKS:  # they have no balanced bend
        values["bend"] = "zigzag"
    tables = [
        replace(table, **{key: values[key] for key in table.declared if key in values})
        for table in setup.tables.values()
    ]
    filled = Setup(setup.name, *tables)  # type: ignore[arg-type]
    if "mass_kg" in values:
        filled.robot_table.check_mass()
    return filled


def template_setup(path: str | Path | None, name: str) -> Setup:
    """Return the set-up of another session, or the proposed one; raises BadInput."""
    proposed = default_setup(name)
    if path is None:
        return proposed
    template = read_session(path).setup
    tools = replace(template.instruments, incline_zero_sigma_deg=ASSUMED_ZERO_SIGMA_DEG)
    return replace(template, name=name, provenance=proposed.provenance, instruments=tools)


def create_session(folder: str | Path, setup: Setup) -> Path:
    """Make a session's folder; session.toml comes last, so that a folder with one is whole.

    Raises BadInput where there is a session already, OSError where it cannot be written.
    """
    folder = Path(folder)
    refuse_existing(folder)
    folder.mkdir(parents=True, exist_ok=True)
    for name, columns in (("readings.csv", READING_COLUMNS), ("events.csv", EVENT_COLUMNS)):
        write_text(folder / name, csv_line(list(columns)))
    write_text(folder / "session.toml", setup.text(PROGRAM, utc_now()))
    return folder


def refuse_existing(folder: Path) -> None:
    """Raise BadInput where there is a session already."""
    if (folder / "session.toml").exists():
        raise BadInput(
            f"{folder}: there is a session already, and nothing overwrites it; go on with "
            f"`serpenoid calibrate {folder}`, or give the new one another name"
        )
