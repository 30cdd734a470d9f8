"""A gait driven on the robot: watched, shown live, and summed up."""

from __future__ import annotations

import time
from contextlib import nullcontext, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import serpenoid as sn

from ...base.errors import RobotUnattended
from ...robot.robot_match import RobotMatch
from ...robot.tools.driven_run import UNATTENDED_S, DrivenRun
from ...servos.speed_limit import too_fast_text
from ...show.live import View, show_summary, view
from ...show.screen import say
from ..options import describe, interruptible, show_json, warn_of_two_motions

if TYPE_CHECKING:
    from ...prediction.band import SpeedBand


def drive_gait(
    gait: sn.Gait,
    as_json: bool,
    fit: sn.FrictionFit | None = None,
    *,
    duration_s: float | None = None,
    port: str | None = None,
    record: Path | None = None,
    match: RobotMatch | None = None,
    before: dict[str, Any] | None = None,
    servo: sn.ServoKind | None = None,
    notes: dict[str, Any] | None = None,
) -> None:
    """Drive a gait, show it, and sum it up, as the command `drive` says.

    fit: of this robot's friction, if there is one; servo: what moves its joints; match: the robot
    that the gait is for, that of the fit unless given. A board of other joints is refused. before:
    what a command that drives afterwards has found; with as_json all is one document, the run under
    "drive". notes: what JSON says beside.
    """
    band = None
    if fit is None and (too_fast := too_fast_text(gait, servo)):
        say(f"serpenoid: warning: {too_fast}", err=True)
    if fit is not None:
        band = _predicted(fit, gait, as_json, servo)
        match = match or RobotMatch(
            fit.robot.links, "the friction", "give the session of this robot, or none"
        )
    run = DrivenRun(gait, port, record, match)
    try:
        with nullcontext(_show_nothing) if as_json else view(band) as show:
            interrupted = _watch(run, duration_s, show)
    finally:  # a run that failed has a summary too
        values = before or {}
        if (summary := run.summary()) is not None:
            frame_ms = run.robot.hello.frame_us / 1e3
            if band and servo and frame_ms != round(1e3 * servo.servo.frame_s, 3):
                say(
                    f"note: this board sets its servos every {frame_ms:g} ms, and the prediction "
                    f"is for {1e3 * servo.servo.frame_s:g} ms: give --set frame_ms={frame_ms:g}",
                    err=True,
                )
            told = {"gait": describe(run.gait), "frame_ms": frame_ms}
            told |= {"predicted": band.to_dict()} if band else {}
            told |= vars(summary)
            values = told if before is None else before | {"drive": told}
            if not as_json:
                show_summary(summary, band)
        if as_json and values:
            show_json(values | (notes or {}))
    if interrupted and duration_s is not None:
        raise SystemExit(130)


def _predicted(
    fit: sn.FrictionFit, gait: sn.Gait, quiet: bool, servo: sn.ServoKind | None
) -> SpeedBand:
    """Return the speed to expect, told before anything moves."""
    from ...prediction.band import speed_band

    band = interruptible(lambda: speed_band(fit, gait, servo=servo))
    with suppress(sn.NotConverged):
        warn_of_two_motions(sn.steady_gait(fit.robot, fit.ground, gait))
    if not quiet:
        say(f"predicted: {band.in_words()}")
    return band


def _show_nothing(run: DrivenRun) -> None:
    """Stand for a display."""


def _watch(run: DrivenRun, duration_s: float | None, show: View) -> bool:
    """Drive; return whether Ctrl-C ended it."""
    shown_in_s = 0.0

    def timed(now: DrivenRun) -> None:
        nonlocal shown_in_s
        begun_s = time.monotonic()
        show(now)
        shown_in_s = time.monotonic() - begun_s

    try:
        run.run(duration_s, timed)
    except RobotUnattended as error:
        if shown_in_s < 0.5 * UNATTENDED_S:  # something else held the program up
            raise
        raise RobotUnattended(
            f"the terminal took nothing for {UNATTENDED_S:g} s, so the robot was stopped; Ctrl-S "
            "halts a terminal and Ctrl-Q lets it go on: start again, or pipe the output to a file"
        ) from error
    except KeyboardInterrupt:
        if run.last is None:
            raise
        return True
    return False
