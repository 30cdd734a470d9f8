"""The commands that deal with a board: ports, flash, doctor, trim, drive and monitor."""

from __future__ import annotations

import math
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import click

import serpenoid as sn

from ..base.checks import POSITIVE, Limits
from ..show.screen import say
from .declare import OutFile, Values, command, flag, number, option, settings
from .options import (
    AS_JSON,
    OFFSET,
    PLUG,
    Snake,
    busy,
    describe,
    gait_options,
    make_gait,
    make_snake,
    robot_option,
    servo_option,
    show_json,
    take_servo,
    warn_of_two_motions,
)
from .predict import expect

PORT = option(
    "--port",
    "Serial port; found by its USB id unless given. `virtual` or `virtual:joints=9` needs no "
    "robot.",
)


@command()
@AS_JSON
def ports(as_json: bool) -> None:
    """List the serial ports: which may be the robot, and whether this user may open them."""
    from ..robot.wire.ports import port_states, why_no_port

    ports = port_states()
    if as_json:
        return show_json({"ports": ports})
    for port in ports:
        chip = port["chip"] and f"likely a board ({port['chip']})"
        closed = "" if port["allowed"] else "this user may not open it: try `serpenoid doctor`"
        about = port["device"], port["usb"], chip, port["description"], closed
        say("  ".join(filter(None, about)))
    if not any(port["chip"] for port in ports):
        say(f"no board found by its USB id. {why_no_port()}", err=True)


@command()
@option(
    "--board", "Needed where the USB id does not tell.", choice=["uno", "nano", "nano_old", "mega"]
)
@option("--port", "Serial port; found by its USB id unless given.")
@option("--joints", "How many joints the robot has: its links less one.", default=5)
@option(
    "--output",
    "Where servos are wired. pca9685 has run on a simulated chip only.",
    choice=["servo", "pca9685"],
    default="servo",
)
@AS_JSON
def flash(
    board: str | None,
    port: str | None,
    joints: int,
    output: str,
    as_json: bool,
) -> None:
    """Build the firmware and put it on the board, by PlatformIO, then wait for its greeting."""
    from dataclasses import asdict

    from ..robot.tools.upload import flash as build_and_upload

    if output == "pca9685":
        say(
            "serpenoid: warning: the driver of the PCA9685 has run on a simulated chip only. Keep "
            "the horns off until the first power-on (docs/first_day.md) is done.",
            err=True,
        )
    hello = build_and_upload(
        board,
        port,
        lambda text: say(text.replace("\r", "\n"), nl=False, err=True),
        joints=joints,
        output=output,
    )
    if as_json:
        show_json(asdict(hello))
    else:
        say(
            f"the {hello.board} runs firmware {hello.firmware}, protocol {hello.protocol}; "
            "next: `serpenoid doctor`, then `serpenoid trim`"
        )


MARKS = {"ok": "ok  ", "note": "note", "fix": "FIX "}


@command()
@PORT
@number("--listen-s", "How long to listen to the board; 3.", limits=Limits(0.2, 600), default=3.0)
@flag("--limp", "Ask whether servos go limp when pulses end, and keep it on the board: it moves.")
@AS_JSON
def doctor(port: str | None, listen_s: float, limp: bool, as_json: bool) -> None:
    """Find what keeps the robot from working, and say the fix; nothing moves without --limp.

    Exit status 0 if all is well, 1 if there is something to fix.
    """
    from ..robot.tools.doctor import examine
    from ..robot.tools.keys import need_terminal
    from ..robot.tools.limp_test import limp_test

    if limp:
        need_terminal()
    findings = []
    for finding in examine(port, listen_s):
        findings.append(finding)
        if not as_json:
            say(f"{MARKS[finding.mark]}  {finding.name}: {finding.found}")
            if finding.fix:
                say(f"      -> {finding.fix}")
    well = all(finding.mark != "fix" for finding in findings)
    if as_json:
        show_json({"well": well, "findings": [vars(finding) for finding in findings]})
    if not well:
        raise SystemExit(1)
    if limp:
        result = limp_test(port, lambda text: click.confirm(text, err=True))
        say(f"kept on the board: {result}" if result else "not tried", err=True)


@command()
@PORT
@AS_JSON
def trim(port: str | None, as_json: bool) -> None:
    """Centre each servo by typed numbers; `save` keeps them. The robot straightens first."""
    import sys
    from dataclasses import asdict

    from ..robot.robot import RobotBoard
    from ..robot.tools.trimming import UNATTENDED_S, Trimming, straighten

    with RobotBoard(port, unattended_s=UNATTENDED_S) as robot:
        straighten(robot)
        work = Trimming(robot, lambda text: say(text, err=True))
        work.obey_all(iter(sys.stdin.readline, ""))
    if as_json:
        show_json({"saved": not work.unsaved, "trims": [asdict(t) for t in work.trims]})


@command()
@PORT
@flag("--all", "everything", "Every telemetry line, not one a second.")
def monitor(port: str | None, everything: bool) -> None:
    """Talk to the board: each line is checked, `!` and Enter stop the robot, Ctrl-C leaves.

    Lines from a pipe are sent one by one: `echo status | serpenoid monitor`.
    """
    from ..robot.tools.monitor import converse

    converse(port, 1 if everything else 50)


DRIVE_SERVOS = 64  # sampled servos for the range of the predicted speed; they take a second


@command()
@robot_option
@gait_options
@servo_option
@number("--duration-s", "How long; until Ctrl-C unless given.", limits=POSITIVE)
@PORT
@option("--record", "New file for every line of the run.", type=OutFile())
@settings(OFFSET, *PLUG)
@AS_JSON
def drive(
    robot: str | None,
    servo: str | None,
    duration_s: float | None,
    port: str | None,
    record: Path | None,
    settings: Values,
    as_json: bool,
    **typed_gait: Any,
) -> None:
    """Drive a gait and watch it; Ctrl-C stops the robot first. Lay it straight before.

    With --robot the predicted speed and distance stand beside, with any hobby servo unless --servo
    says which. `serpenoid view` shows the recording afterwards.

    Exit status 0 at the end of --duration-s, or at Ctrl-C where none was given; 130 at an earlier
    Ctrl-C.
    """
    from ..model.robot import frame_us
    from ..robot.tools.driven_run import DrivenRun
    from ..servos.speed_limit import too_fast_text
    from ..show.live import show_summary, view

    check_board_limits(typed_gait)
    gait, snake = make_gait(typed_gait, settings), make_snake(robot, {}) if robot else None
    kind = take_servo(servo or "hobby", settings, snake)
    if kind and snake and not (snake.session or "frame_ms" in settings):
        kind = kind.at_frames(1e-6 * frame_us(snake.robot.links - 1))
    if not (snake and snake.fit) and (too_fast := too_fast_text(gait, kind)):
        say(f"serpenoid: warning: {too_fast}", err=True)
    run = DrivenRun(gait, port, record, snake.robot.links - 1 if snake else None)
    best = predicted(snake, gait, kind) if snake else None
    if best and not as_json:
        say(f"predicted: {best.in_words()}")
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


def check_board_limits(typed_gait: Values) -> None:
    """Raise BadInput, in the option's name and unit, for a gait that no board takes."""
    from .._core.firmware import GAIT

    fields = {"alpha_deg": ("alpha", 1.0), "omega_rad_s": ("omega", 1.0)}
    fields["frequency_hz"] = "omega", math.tau
    for name, (field, unit) in fields.items():
        _, low, high, _ = GAIT[field]
        if typed_gait[name] is not None:
            option = f"--{name.replace('_', '-')}"
            Limits(low / unit, high / unit).check(option, typed_gait[name])
