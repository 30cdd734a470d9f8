"""`serpenoid drive`: a gait, watched, recorded and summed up."""

from __future__ import annotations

import math
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import serpenoid as sn

from ...base.checks import POSITIVE, Limits
from ..declare import Given, command, number, option, out_file, settings
from ..gaits.steady import expect
from ..given import Snake, make_snake, take_servo
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
    from ...model.robot import frame_us
    from ...robot.robot_match import RobotMatch
    from ...robot.tools.driven_run import DrivenRun
    from ...servos.speed_limit import too_fast_text
    from ...show.live import show_summary, view
    from ...show.screen import say

    check_board_limits(typed_gait)
    gait, snake = make_gait(typed_gait, settings), make_snake(robot, {}) if robot else None
    kind = take_servo(servo or "hobby", settings, snake)
    if kind and snake and not (snake.session or "frame_ms" in settings):
        kind = kind.at_frames(1e-6 * frame_us(snake.robot.links - 1))
    if not (snake and snake.fit) and (too_fast := too_fast_text(gait, kind)):
        say(f"serpenoid: warning: {too_fast}", err=True)
    best = predicted(snake, gait, kind) if snake else None
    if best and not as_json:
        say(f"predicted: {best.in_words()}")
    cure = "give the --robot of this board, or none"
    match = RobotMatch(snake.robot.links, "the gait", cure) if snake else None
    run = DrivenRun(gait, port, record, match)
    try:
        with nullcontext(lambda _: None) if as_json else view(best) as show:
            run.run(duration_s, show)
    except KeyboardInterrupt:
        if run.last is None or duration_s is not None:
            raise
    finally:  # a run that failed has a summary too
        if (summary := run.summary()) is not None:
            frame_ms = run.robot.hello.frame_us / 1e3
            if best and kind and frame_ms != round(1e3 * kind.servo.frame_s, 3):
                words = f"note: the board's frames take {frame_ms:g} ms: give --set frame_ms="
                say(f"{words}{frame_ms:g} for its prediction", err=True)
            values = {"gait": describe(run.gait), "frame_ms": frame_ms}
            values |= {"predicted": best.to_dict()} if best else {}
            if as_json:
                show_json(values | vars(summary) | (snake.notes if snake else {}))
            else:
                show_summary(summary, best)


def predicted(snake: Snake, gait: sn.Gait, servo: sn.ServoKind | None) -> Any:
    """Return the speed to expect of a gait, with what few servos leave of it."""
    state = busy("predicting", lambda _: sn.steady_gait(snake.robot, snake.ground, gait))
    state = warn_of_two_motions(state)
    return busy("predicting", lambda _: expect(snake, state, servo, draws=DRIVE_SERVOS)).best


def check_board_limits(typed_gait: Given) -> None:
    """Raise BadInput, in the option's name and unit, for a gait that no board takes."""
    from ..._core.firmware import GAIT

    fields = {"alpha_deg": ("alpha", 1.0), "omega_rad_s": ("omega", 1.0)}
    fields["frequency_hz"] = "omega", math.tau
    for name, (field, unit) in fields.items():
        _, low, high, _ = GAIT[field]
        if typed_gait[name] is not None:
            option = f"--{name.replace('_', '-')}"
            Limits(low / unit, high / unit).check(option, typed_gait[name])
