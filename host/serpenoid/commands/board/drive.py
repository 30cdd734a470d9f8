"""`serpenoid drive`: a gait, watched and recorded."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..options import AS_JSON, describe, gait_options, make_gait, show_json
from ..paths import OutFile
from .port import PORT

if TYPE_CHECKING:
    from ...model.gait import Gait
    from ...robot.tools.driven_run import DrivenRun


@click.command()
@gait_options
@click.option("--duration-s", type=click.FloatRange(0, min_open=True),
              help="How long; until Ctrl-C unless given.")  # fmt: skip
@PORT
@click.option("--record", type=OutFile(),
              help="New file for every line of the run.")  # fmt: skip
@AS_JSON
def drive(
    duration_s: float | None, port: str | None, record: Path | None, as_json: bool, **given: Any
) -> None:
    """Drive a gait and watch it; Ctrl-C stops the robot first. Lay it straight before.

    Exit status 0 at the end of --duration-s, or at Ctrl-C where none was given; 130 at an earlier
    Ctrl-C.
    """
    drive_gait(make_gait(given), duration_s, port, record, as_json)


def drive_gait(
    gait: Gait, duration_s: float | None, port: str | None, record: Path | None, as_json: bool
) -> None:
    """Drive a gait, show it, and sum it up, as the command `drive` says."""
    from ...robot.tools.driven_run import DrivenRun

    run = DrivenRun(gait, port, record)
    try:
        interrupted = _watch(run, duration_s, as_json)
    finally:  # a run that failed has a summary too
        _sum_up(run, as_json)
    if interrupted and duration_s is not None:
        raise SystemExit(130)


def _watch(run: DrivenRun, duration_s: float | None, quiet: bool) -> bool:
    """Drive; return whether Ctrl-C ended it."""
    from contextlib import nullcontext

    from ...show.live import view

    try:
        with nullcontext(lambda _: None) if quiet else view() as watch:
            run.run(duration_s, watch)
    except KeyboardInterrupt:
        if run.last is None:
            raise
        return True
    return False


def _sum_up(run: DrivenRun, as_json: bool) -> None:
    from ...show.live import show_summary

    found = run.summary()
    if found is None:
        return
    show_json({"gait": describe(run.gait)} | found.to_dict()) if as_json else show_summary(found)
