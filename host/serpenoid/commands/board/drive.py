"""`serpenoid drive`: a gait, watched and recorded."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from ..declare import Range, option, out_file
from ..given import servo_as_filmed, take_fit
from ..options import AS_JSON, fit_options, gait_options, make_gait, servo_option, take_servo
from .tools import PORT


@click.command()
@gait_options
@fit_options
@servo_option
@option("--duration-s", "How long; until Ctrl-C unless given.", type=Range(0, min_open=True))
@PORT
@option("--record", "New file for every line of the run.", type=out_file())
@AS_JSON
def drive(
    duration_s: float | None,
    port: str | None,
    record: Path | None,
    as_json: bool,
    **given: Any,
) -> None:
    """Drive a gait and watch it; Ctrl-C stops the robot first. Lay it straight before.

    With --session DIR or --ground FILE the speed that the fitted friction predicts stands beside,
    with any hobby servo unless --servo says which.

    Exit status 0 at the end of --duration-s, or at Ctrl-C where none was given; 130 at an earlier
    Ctrl-C.
    """
    from .driving import drive_gait

    fit = take_fit(given)
    servo = servo_as_filmed(take_servo("hobby"), fit)
    gait, run = make_gait(given), {"duration_s": duration_s, "port": port, "record": record}
    drive_gait(gait, as_json, fit, servo=servo, **run)
