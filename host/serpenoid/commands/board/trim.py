"""`serpenoid trim`: each servo centred by keys."""

from __future__ import annotations

import click

from ...show.screen import say
from ..options import AS_JSON, show_json
from .port import PORT


@click.command()
@PORT
@AS_JSON
def trim(port: str | None, as_json: bool) -> None:
    """Centre each servo by keys and save that on the board; the robot straightens first."""
    from dataclasses import asdict

    from ...robot.robot import RobotBoard
    from ...robot.tools.keys import keyboard, need_terminal
    from ...robot.tools.trimming import UNATTENDED_S, Trimming, straighten

    need_terminal()
    with RobotBoard(port, unattended_s=UNATTENDED_S) as robot:
        straighten(robot)
        work = Trimming(robot, lambda text: say(text, err=True))
        with keyboard() as keys:
            work.go(keys)
    if as_json:
        show_json({"saved": not work.unsaved, "trims": [asdict(t) for t in work.trims]})
