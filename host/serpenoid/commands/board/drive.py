"""`serpenoid drive`: a gait, watched, recorded and summed up."""

from __future__ import annotations

import time
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import serpenoid as sn

from ...base.checks import POSITIVE
from ..declare import Given, command, number, option, out_file, settings
from ..given import make_snake, servo_remark, take_servo
from ..options import (
    AS_JSON,
    OFFSET,
    PLUG,
    busy,
    describe,
    gait_options,
    make_gait,
    robot_option,
    servo_option,
    show_json,
    warn_of_two_motions,
)
from .tools import PORT

DRIVE_SERVOS = 64  # sampled servos for the range of the predicted speed; they take a second


@command()
@robot_option
@gait_options
@servo_option
@number("--duration-s", "How long; until Ctrl-C unless given.", limits=POSITIVE)
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
    from ...robot.robot_match import RobotMatch
    from ...robot.tools.driven_run import DrivenRun
    from ...servos.speed_limit import too_fast_text
    from ...show.live import show_summary, view
    from ...show.screen import say
    from ..gaits.steady import expect

    gait, snake = make_gait(typed_gait, settings), robot and make_snake(robot, {})
    kind = take_servo(servo, settings, "hobby", snake or None)
    if not (snake and snake.fit) and (too_fast := too_fast_text(gait, kind)):
        say(f"serpenoid: warning: {too_fast}", err=True)
    best = match = None
    if snake:
        state = busy("predicting", lambda _: sn.steady_gait(snake.robot, snake.ground, gait))
        state = warn_of_two_motions(state)
        best = busy("predicting", lambda _: expect(snake, state, kind, draws=DRIVE_SERVOS)).best
        match = RobotMatch(snake.robot.links, "the gait", "give the --robot of this board, or none")
        if not as_json:
            say(f"predicted: {best.in_words()}")
    run = DrivenRun(gait, port, record, match)
    try:
        with nullcontext(lambda _: None) if as_json else view(best) as show:
            interrupted = _watch(run, duration_s, show)
    finally:  # a run that failed has a summary too
        if (summary := run.summary()) is not None:
            frame_ms = run.robot.hello.frame_us / 1e3
            if best and kind and frame_ms != round(1e3 * kind.servo.frame_s, 3):
                say(
                    f"note: this board sets its servos every {frame_ms:g} ms, and the prediction "
                    f"is for {1e3 * kind.servo.frame_s:g} ms: give --set frame_ms={frame_ms:g}",
                    err=True,
                )
            told = {"gait": describe(run.gait), "frame_ms": frame_ms}
            told |= {"predicted": best.to_dict()} if best else {}
            notes = (snake.notes if snake else {}) | servo_remark(kind)
            if as_json:
                show_json(told | vars(summary) | notes)
            else:
                show_summary(summary, best)
    if interrupted and duration_s is not None:
        raise SystemExit(130)


def _watch(run: Any, duration_s: float | None, show: Any) -> bool:
    """Drive; return whether Ctrl-C ended it."""
    from ...base.errors import RobotUnattended
    from ...robot.tools.driven_run import UNATTENDED_S

    shown_in_s = 0.0

    def timed(now: Any) -> None:
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
