"""`serpenoid calibrate new`: a session's set-up, asked for in the units that people have."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ...base.errors import BadInput
from ...show.screen import say
from ..declare import FOLDER, Given, command, flag, option

if TYPE_CHECKING:
    from ...session.settings import Setup
    from ...taking.new_session import Question


def quantity_of(name: str, unit: str = "") -> Callable[[Any], float | str]:
    """Return the type of a number with a unit or in the one given, with a point or a comma.

    A bare number that only another unit makes likely is asked about where somebody can answer.
    `later` answers for a mass or a voltage.
    """

    def quantity(value: Any) -> float | str:
        import sys

        from ...taking.new_session import LATER
        from ...taking.parse_number import parse_number

        if isinstance(value, float):
            return value
        question = question_of(name)
        if question.later and str(value).strip().lower() == LATER:
            return LATER
        try:
            typed = parse_number(str(value), question.field, unit=unit)
        except BadInput as error:
            raise click.BadParameter(str(error)) from None
        if not typed.question or typed.meant is None:
            return typed.value
        if not sys.stdin.isatty():
            raise click.BadParameter(f"{typed.question} Type the unit, too")
        if click.confirm(typed.question, default=True):
            return typed.meant
        raise click.BadParameter("then type it anew, with its unit")

    return quantity


def question_of(name: str) -> Question:
    """Return one of the numbers that are asked for."""
    from ...taking.new_session import QUESTIONS

    return next(question for question in QUESTIONS if question.key == name)


@command()
@click.argument("folder", type=FOLDER)
@option(
    "--template",
    "Another session's folder, whose set-up is taken over unasked.",
    type=click.Path(exists=True, path_type=Path),
)
@flag("--defaults", "Ask nothing: 2005 robot, a home treadmill.")
@option("--surface", "What the wheels roll on.")
@option(
    "--mass-kg",
    "Mass of the whole robot, as it crawls; 480g does, too.",
    type=quantity_of("mass_kg"),
)
@option(
    "--on",
    "Where: a treadmill, or pushes along a floor.",
    choice=["treadmill", "floor"],
    default="treadmill",
)
@option(
    "--joints",
    "What sets the joints: servos, a straightedge, or the hand alone.",
    choice=["servos", "straightedge", "hand"],
)
@option(
    "--wheels-kg",
    "Mass of all wheels together, which a push sets turning.",
    type=quantity_of("wheels_kg"),
)
@option(
    "--volts",
    "supply_v",
    "Voltage at the servos' plug, measured while they move.",
    type=quantity_of("supply_v"),
)
@flag("--simulated", "Say in the session that it is no measurement.")
def new(
    folder: Path,
    template: Path | None,
    defaults: bool,
    simulated: bool,
    on: str,
    **answers: Any,
) -> None:
    """Begin a session: asks for robot, surface and instruments, or takes them from a template."""
    import sys
    from dataclasses import replace

    from ...taking.new_session import (
        LATER,
        answered,
        create_session,
        on_place,
        refuse_existing,
        template_setup,
    )

    refuse_existing(folder)
    setup = template_setup(template, os.path.basename(os.path.abspath(folder)))
    if template is None and not defaults and not (answers["surface"] and answers["mass_kg"]):
        if not sys.stdin.isatty():
            raise BadInput(
                "there is no terminal to ask at; give --template DIR, or --defaults with "
                "--surface and --mass-kg"
            )
        answers = _asked(setup, answers, on)
    elif template is None and answers["mass_kg"] is None and not simulated:
        answers["mass_kg"] = LATER
    given = answered(replace(setup, plan=on_place(setup.plan, on)), answers)
    if simulated:
        source = replace(given.provenance, kind="simulated", source=f"simulated {on}")
        given = replace(given, provenance=source)
    create_session(folder, given)
    from ...model.gait import gait_name
    from ...servos.catalogue import HOBBY
    from ...servos.speed_limit import too_fast_text

    for gait in given.plan.gaits:
        if too_fast := too_fast_text(gait, given.driving(HOBBY), gait_name(gait)):
            say(f"serpenoid: warning: {too_fast}", err=True)
    say(f"begun: {folder / 'session.toml'}; go on with `serpenoid calibrate {folder}`")


def _asked(setup: Setup, answers: Given, on: str) -> Given:
    """Ask what is not answered yet; Enter takes what stands in brackets."""
    from ...session.declaration import BELT_UNITS
    from ...taking.new_session import JOINT_SIGMA_DEG, QUESTIONS, WORDS

    say("Enter takes what stands in brackets; numbers may be typed with their units.")
    answered = dict(answers)
    for name, words in WORDS.items():
        if answered.get(name) is None:
            answered[name] = click.prompt(words, default=getattr(setup.laboratory, name))
    links = click.IntRange(2, 100)
    answered["links"] = click.prompt("number of links", default=setup.robot.links, type=links)
    if answered.get("joints") is None:
        answered["joints"] = click.prompt(
            "what sets the joints: servos, straightedge, or hand (by eye they are 1.5 deg off)",
            default="servos",
            type=click.Choice(list(JOINT_SIGMA_DEG)),
            show_choices=False,
        )
    belt_unit = ""
    if on == "treadmill":
        choice = click.Choice(BELT_UNITS)
        belt_unit = click.prompt("unit of the belt's speed", default="km/h", type=choice)
        answered["belt_speed_unit"] = belt_unit
    for question in QUESTIONS:
        field = question.field
        if answered.get(question.key) is None and question.on in ("", on):
            unit = belt_unit if belt_unit in field.units else ""
            kind = click.types.FuncParamType(quantity_of(question.key, unit))
            answered[question.key] = click.prompt(
                field.words, default=question.usual_of(setup), type=kind
            )
    return answered
