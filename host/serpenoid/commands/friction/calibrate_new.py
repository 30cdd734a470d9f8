"""The command `serpenoid calibrate new`: begin a session and ask for its set-up."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import click

from ...base.errors import BadInput
from ...show.screen import say
from ..declare import command, flag, number, option


@command()
@option(
    "--template",
    "Another session's folder, whose set-up is copied without questions.",
    type=click.Path(exists=True, path_type=Path),
)
@flag("--defaults", "Ask nothing; take the 2005 robot and a home treadmill.")
@option("--surface", "What the wheels roll on.")
@number("--mass-kg", "Mass of the whole robot, as it crawls.")
@option(
    "--on",
    "Method: stations on a treadmill, or pushes along a floor.",
    choice=["treadmill", "floor"],
    default="treadmill",
)
@flag("--simulated", "Mark the session as simulated, not measured.")
def new(
    folder: Path,
    template: Path | None,
    defaults: bool,
    simulated: bool,
    on: str,
    **answers: Any,
) -> None:
    """Begin a session: ask for robot, surface and instruments, or copy them from a template."""
    import sys
    from dataclasses import replace

    from ...taking.asking import WORDS, Asker, Quit
    from ...taking.new_session import (
        answered,
        ask_setup,
        create_session,
        on_place,
        refuse_existing,
        template_setup,
    )
    from ...taking.terminal import Console

    refuse_existing(folder)
    setup = template_setup(template, os.path.basename(os.path.abspath(folder)))
    setup = replace(setup, plan=on_place(setup.plan, on))
    if template is None and not defaults and not (answers["surface"] and answers["mass_kg"]):
        if not sys.stdin.isatty():
            raise BadInput(
                "there is no terminal to ask at; give --template DIR, or --defaults with "
                "--surface and --mass-kg"
            )
        say(f"{WORDS} Enter takes the value in brackets; units may be typed.")
        try:
            setup = ask_setup(Asker(Console()), setup, answers, on)
        except (Quit, EOFError):
            return say("Left; nothing was written.")
    else:
        if template is None and answers["mass_kg"] is None and not simulated:
            answers["mass_kg"] = ""
        setup = answered(setup, answers)
    if simulated:
        source = replace(setup.provenance, kind="simulated", source=f"simulated {on}")
        setup = replace(setup, provenance=source)
    create_session(folder, setup)
    return say(f"begun: {folder / 'session.toml'}; go on with `serpenoid calibrate {folder}`")
