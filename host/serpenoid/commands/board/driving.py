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
    from ...show.live import Predicted
    from ..given import Snake


DRIVE_SERVOS = 64  # sampled servos for the range of the predicted speed; they take a second


def drive_gait(
    gait: sn.Gait,
    as_json: bool,
    snake: Snake | None = None,
    *,
    duration_s: float | None = None,
    port: str | None = None,
    record: Path | None = None,
    before: dict[str, Any] | None = None,
    servo: sn.ServoKind | None = None,
    notes: dict[str, Any] | None = None,
) -> None:
    """Drive a gait, show it, and sum it up, as the command `drive` says.

    snake: this robot, if its speed is to be predicted; servo: what moves its joints. A board of
    other joints than the snake's is refused. before: what a command that drives afterwards has
    found; with as_json all is one document, the run under "drive". notes: what JSON says beside.
    """
    band = match = None
    if (snake is None or snake.fit is None) and (too_fast := too_fast_text(gait, servo)):
        say(f"serpenoid: warning: {too_fast}", err=True)
    if snake is not None:
        band = _predicted(snake, gait, servo)
        if not as_json:
            say(f"predicted: {band.in_words()}")
        match = RobotMatch(snake.robot.links, "the gait", "give the --robot of this board, or none")
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


def _predicted(snake: Snake, gait: sn.Gait, servo: sn.ServoKind | None) -> Predicted:
    """Return the speed to expect: the band of a fit, else the speed with servos of this robot."""
    from ...periodic.servo_steady import with_servo
    from ...prediction.band import speed_band

    if (fit := snake.fit) is not None:
        band = interruptible(lambda: speed_band(fit, gait, servo=servo))
        with suppress(sn.NotConverged):
            warn_of_two_motions(sn.steady_gait(snake.robot, snake.ground, gait))
        return band
    state = warn_of_two_motions(
        interruptible(lambda: sn.steady_gait(snake.robot, snake.ground, gait))
    )
    if servo is None:
        return state
    return interruptible(lambda: with_servo(state, servo, DRIVE_SERVOS))


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
