"""Whose session it is: asked when one is resumed, so that two robots never share one."""

from __future__ import annotations

import math
from dataclasses import replace

from ....model.errors import BadInput
from ....model.robot import Robot
from ...kinds.declaration import Field
from ...session import Setup
from ...settings import quoted
from ..journal import Journal
from ..new_session import LENGTH, MASS, WORDS, identity_differences
from ..parse_number import parse_number
from .prompt import Left
from .terminal import Terminal

LINKS = Field("links", "number of links", 2.0, 100.0)


def ask_identity(journal: Journal, terminal: Terminal) -> str:
    """Ask whether robot and surface are the session's, and who measures; return the latter.

    What the set-up left open is asked for and amended. Raises BadInput with the differences where
    the robot is another, Left and EOFError where the person leaves.
    """
    setup = journal.session.setup
    if journal.numbers:
        _confirm(journal, terminal)
    if not setup.weighed:
        _weigh(journal, terminal)
    if setup.surface == "not said":
        said = _ask(terminal, f"  {WORDS['surface']} [not now]: ")
        if said:
            journal.event("amend", detail=f"laboratory.surface = {quoted(said)}")
    if not journal.numbers:
        return setup.people
    people = _ask(terminal, f"Who measures now? Enter: {setup.people}. ")
    return people or setup.people


def in_words(setup: Setup) -> str:
    """Return robot and surface in words."""
    robot = setup.robot
    weighed = "" if setup.weighed else " (not weighed)"
    return (
        f"{robot.links} links of {1000 * robot.link_length_m:.4g} mm, "
        f"{1000 * robot.links * robot.link_mass_kg:.4g} g{weighed}, on {setup.surface}"
    )


def refuse_another(journal: Journal, here: Setup) -> None:
    """Raise BadInput, with the differences, where the robot or surface here is another."""
    lines = identity_differences(journal.session.setup, here)
    if lines:
        folder = journal.folder
        raise BadInput(
            f"{folder} is a session of another robot or surface:\n  "
            + "\n  ".join(lines)
            + f"\nbegin a session for this one: serpenoid calibrate new OTHER --template {folder}\n"
            f"if the session's own value is mistyped: serpenoid calibrate amend {folder} "
            "robot.mass_kg=480g"
        )


def _confirm(journal: Journal, terminal: Terminal) -> None:
    setup = journal.session.setup
    terminal.say(f"Resumed: {setup.name}, {in_words(setup)}.")
    while True:
        answer = _ask(terminal, "Is it this robot, on this surface? Enter: yes, n: no. ").lower()
        if answer in ("", "y", "yes"):
            return
        if answer in ("n", "no"):
            break
    refuse_another(journal, _here(setup, terminal))
    terminal.say("Nothing differs: it is the same robot.")


def _here(setup: Setup, terminal: Terminal) -> Setup:
    """Return the set-up with what the person says of the robot that lies here."""
    robot = setup.robot
    terminal.say("What lies here, then? Enter where it is as the session has it.")
    links = round(_number(LINKS, robot.links, terminal))
    mass_kg = _number(MASS.field, robot.links * robot.link_mass_kg, terminal)
    length_m = _number(LENGTH.field, robot.link_length_m, terminal)
    surface = _ask(terminal, f"  {WORDS['surface']} [{setup.surface}]: ") or setup.surface
    return replace(setup, robot=Robot(links, mass_kg / links, length_m), surface=surface)


def _weigh(journal: Journal, terminal: Terminal) -> None:
    """Ask for a mass that nobody has weighed yet; Enter leaves it open."""
    mass_kg = _number(MASS.field, math.nan, terminal)
    if math.isfinite(mass_kg):
        journal.event("amend", detail=f"robot.mass_kg = {mass_kg!r}")


def _number(field: Field, usual: float, terminal: Terminal) -> float:
    """Return the number typed, `usual` for Enter; what is none is told, and asked for again."""
    shown = "not now" if math.isnan(usual) else f"{usual:.6g}"
    while True:
        text = _ask(terminal, f"  {field.words} [{shown}]: ")
        if not text:
            return usual
        try:
            typed = parse_number(text, field)
        except BadInput as error:
            terminal.say(f"  ! {error}")
            continue
        if not typed.question or typed.meant is None:
            return typed.value
        if _ask(terminal, f"  {typed.question} Enter: yes, n: no. ").lower() in ("", "y", "yes"):
            return typed.meant


def _ask(terminal: Terminal, prompt: str) -> str:
    line = None
    while line is None:
        line = terminal.ask(prompt, math.inf, lambda: None)
    if line.lower() in ("q", "quit", "exit"):
        raise Left
    return line
