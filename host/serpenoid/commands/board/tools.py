"""The commands that get a board to work: ports, flash, doctor, trim, monitor."""

from __future__ import annotations

import click

from ...base.checks import Limits
from ...show.screen import say
from ..declare import command, flag, number, option
from ..options import AS_JSON, show_json

PORT = option(
    "--port",
    "Serial port; found by its USB id unless given. `virtual` or `virtual:joints=9` needs no "
    "robot.",
)


@command()
@AS_JSON
def ports(as_json: bool) -> None:
    """List the serial ports: which may be the robot, and whether this user may open them."""
    from ...robot.wire.ports import port_states, why_no_port

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

    from ...robot.tools.upload import flash as build_and_upload

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
    from ...robot.tools.doctor import examine
    from ...robot.tools.keys import need_terminal
    from ...robot.tools.limp_test import limp_test

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
        found = limp_test(port, lambda text: click.confirm(text, err=True))
        say(f"kept on the board: {found}" if found else "not tried", err=True)


@command()
@PORT
@AS_JSON
def trim(port: str | None, as_json: bool) -> None:
    """Centre each servo by typed numbers; `save` keeps them. The robot straightens first."""
    import sys
    from dataclasses import asdict

    from ...robot.robot import RobotBoard
    from ...robot.tools.trimming import UNATTENDED_S, Trimming, straighten

    with RobotBoard(port, unattended_s=UNATTENDED_S) as robot:
        straighten(robot)
        work = Trimming(robot, lambda text: say(text, err=True))
        work.go(iter(sys.stdin.readline, ""))
    if as_json:
        show_json({"saved": not work.unsaved, "trims": [asdict(t) for t in work.trims]})


@command()
@PORT
@flag("--all", "everything", "Every telemetry line, not one a second.")
def monitor(port: str | None, everything: bool) -> None:
    """Talk to the board: each line is checked, `!` and Enter stop the robot, Ctrl-C leaves.

    Lines from a pipe are sent one by one: `echo status | serpenoid monitor`.
    """
    from ...robot.tools.monitor import converse

    converse(port, 1 if everything else 50)
