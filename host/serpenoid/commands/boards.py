"""The commands that deal with a board: ports, flash, doctor, trim, drive and monitor."""

from __future__ import annotations

from contextlib import nullcontext
from functools import partial
from pathlib import Path
from typing import Any

import click

import serpenoid as sn

from ..show.screen import say
from .declare import OutFile, Values, command, flag, number, option, settings
from .options import (
    busy,
    describe,
    make_gait,
    make_snake,
    show_json,
    typed_servo,
    warn_of_two_motions,
)
from .predict import expect


@command()
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
    "--board",
    "Kind of board; needed where the USB id does not tell.",
    choice=["uno", "nano", "nano_old", "mega"],
)
@option("--joints", "How many joints the robot has: its links less one.", default=5)
@option(
    "--output",
    "Where servos are wired; pca9685 has run on a simulated chip only: keep horns off at first.",
    choice=["servo", "pca9685"],
    default="servo",
)
def flash(board: str | None, port: str | None, joints: int, output: str) -> None:
    """Build the firmware and put it on the board, by PlatformIO, then wait for its greeting."""
    from ..robot.tools.upload import flash as build_and_upload

    hello = build_and_upload(
        board,
        port,
        lambda text: say(text.replace("\r", "\n"), nl=False, err=True),
        joints=joints,
        output=output,
    )
    say(
        f"the {hello.board} runs firmware {hello.firmware}, protocol {hello.protocol}; "
        "next: `serpenoid doctor`, then `serpenoid trim`"
    )


@command()
@number("--listen-s", "How long to listen to the board.", default=3.0)
@flag(
    "--limp",
    "Try whether servos go limp when pulses end; keep the answer on the board. It moves.",
)
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
            say(f"{finding.mark:4}  {finding.name}: {finding.found}")
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
def trim(port: str | None) -> None:
    """Centre each servo by typed numbers; `save` keeps them. The robot straightens first."""
    import sys

    from ..robot.robot import RobotBoard
    from ..robot.tools.trimming import UNATTENDED_S, trim_servos

    with RobotBoard(port, unattended_s=UNATTENDED_S) as robot:
        trim_servos(robot, iter(sys.stdin.readline, ""), say)


@command()
def monitor(port: str | None) -> None:
    """Talk to the board: each line is checked, `!` and Enter stop the robot, Ctrl-C leaves.

    Of telemetry, which `set every` thins out, one line in fifty is shown.
    Lines from a pipe are sent one by one: `echo status | serpenoid monitor`.
    """
    from ..robot.tools.monitor import converse

    converse(port)


@command()
@option(
    "--duration-s",
    "How long to drive; until Ctrl-C unless given.",
    type=click.FloatRange(0, min_open=True),
)
@option("--record", "New file for every line of the run.", type=OutFile())
@settings("offset", "plug")
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
    """Drive a gait and watch it; Ctrl-C stops the robot. Lay the robot straight first.

    With --robot, which has no default here, the predicted speed and distance stand beside, with any
    hobby servo unless --servo says which. `serpenoid view` shows the recording afterwards.

    Exit status 0 at the end of --duration-s, or at Ctrl-C where none was given; 130 at an earlier
    Ctrl-C.
    """
    from ..model.robot import frame_us
    from ..robot.tools.driven_run import DrivenRun
    from ..servos.speed_limit import too_fast_text
    from ..show.live import show_summary, view

    gait, snake = make_gait(settings | typed_gait), make_snake(robot, {}) if robot else None
    kind = typed_servo(servo, settings, snake)
    if kind and snake and not (snake.session or "frame_ms" in settings):
        kind = kind.at_frames(1e-6 * frame_us(snake.robot.links - 1))
    if not (snake and snake.fit) and (too_fast := too_fast_text(gait, kind)):
        say(f"serpenoid: warning: {too_fast}", err=True)
    run = DrivenRun(gait, port, record, snake.robot.links - 1 if snake else None)
    best = None
    if snake:
        body = snake.robot, snake.ground, gait
        state = warn_of_two_motions(busy("predicting", lambda _: sn.steady_gait(*body)))
        predict = partial(expect, snake, state, kind, draws=64)  # servos: they take a second
        best = busy("predicting", predict).best
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
            values = {"gait": describe(run.gait), "frame_ms": run.robot.hello.frame_us / 1e3}
            values |= {"predicted": best.to_dict()} if best else {}
            if as_json:
                show_json(values | vars(summary) | (snake.notes if snake else {}))
            else:
                show_summary(summary, best)
