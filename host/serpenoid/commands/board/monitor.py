"""`serpenoid monitor`: a person talks to the board."""

from __future__ import annotations

import click

from ..declare import flag
from .port import PORT


@click.command()
@PORT
@flag("--all", "everything", "Every telemetry line, not one a second.")
def monitor(port: str | None, everything: bool) -> None:
    """Talk to the board: each line is checked, `!` stops the robot at once, Ctrl-C leaves.

    Lines from a pipe are sent one by one: `echo status | serpenoid monitor`.
    """
    from ...robot.tools.monitor import converse

    converse(port, 1 if everything else 50)
