"""`serpenoid drive`: a gait, watched and recorded."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from ..declare import Command, Given, Number, option, out_file, settings
from ..given import make_snake, servo_remark, take_servo
from ..options import AS_JSON, OFFSET, PLUG, gait_options, make_gait, robot_option, servo_option
from .tools import PORT


@click.command(cls=Command)
@robot_option
@gait_options
@servo_option
@option("--duration-s", "How long; until Ctrl-C unless given.", type=Number(0, open_low=True))
@PORT
@option("--record", "New file for every line of the run.", type=out_file())
@settings(OFFSET, *PLUG)
@AS_JSON
def drive(
    robot: str | None,
    servo: str | None,
    duration_s: float | None,
    port: str | None,
    record: Path | None,
    settings: Given,
    as_json: bool,
    **typed_gait: Any,
) -> None:
    """Drive a gait and watch it; Ctrl-C stops the robot first. Lay it straight before.

    With --robot the predicted speed and distance stand beside, with any hobby servo unless --servo
    says which. `serpenoid view` shows the recording afterwards.

    Exit status 0 at the end of --duration-s, or at Ctrl-C where none was given; 130 at an earlier
    Ctrl-C.
    """
    from .driving import drive_gait

    snake = None if robot is None else make_snake(robot, {})
    kind = take_servo(servo, settings, "hobby", snake)
    gait, run = make_gait(typed_gait, settings), {"duration_s": duration_s, "port": port}
    notes = (snake.notes if snake else {}) | servo_remark(kind)
    drive_gait(gait, as_json, snake, servo=kind, record=record, notes=notes, **run)
