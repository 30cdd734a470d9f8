"""The commands that deal with a robot: ports, doctor, flash, drive, trim, monitor."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from .options import AS_JSON, describe, gait_options, make_gait, show_json
from .paths import OutFile

if TYPE_CHECKING:
    from ..robot.tools.driven_run import Drive

PORT = click.option(
    "--port", help="Serial port; found by its USB id unless given. `virtual` needs no robot."
)
MARKS = {"ok": "ok  ", "note": "note", "fix": "FIX "}


@click.command()
@AS_JSON
def ports(as_json: bool) -> None:
    """List the serial ports: which may be the robot, and who has them open."""
    from ..robot.wire.culprit import why_no_port
    from ..robot.wire.ports import port_states

    found = port_states()
    if as_json:
        show_json({"ports": [port.to_dict() for port in found]})
        return
    for port in found:
        about = [port.device, port.usb, port.chip and f"likely a board ({port.chip})"]
        about += [port.description, *(f"open in {h.name} ({h.pid})" for h in port.held_by)]
        about += [] if port.allowed else ["this user may not open it: try `serpenoid doctor`"]
        click.echo("  ".join(part for part in about if part))
    if not any(port.chip for port in found):
        click.echo(f"no board found by its USB id. {why_no_port()}", err=True)


@click.command()
@PORT
@click.option("--listen-s", type=click.FloatRange(0, 600), default=3.0, show_default=True,
              help="How long to listen to the board.")  # fmt: skip
@AS_JSON
def doctor(port: str | None, listen_s: float, as_json: bool) -> None:
    """Find what keeps the robot from working, and say the fix; nothing moves.

    Exit status 0 if all is well, 1 if there is something to fix.
    """
    from ..robot.tools.doctor import examine

    findings = []
    for finding in examine(port, listen_s):
        findings.append(finding)
        if not as_json:
            click.echo(f"{MARKS[finding.mark]}  {finding.name}: {finding.found}")
            if finding.fix:
                click.echo(f"      -> {finding.fix}")
    well = all(finding.mark != "fix" for finding in findings)
    if as_json:
        show_json({"well": well, "findings": [finding.to_dict() for finding in findings]})
    if not well:
        raise SystemExit(1)


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
    from ..robot.tools.driven_run import Drive

    run = Drive(make_gait(given), port, record)
    try:
        interrupted = _drive(run, duration_s, as_json)
    finally:  # a run that failed has a summary too
        _sum_up(run, as_json)
    if interrupted and duration_s is not None:
        raise SystemExit(130)


def _drive(run: Drive, duration_s: float | None, quiet: bool) -> bool:
    """Drive; return whether Ctrl-C ended it."""
    from contextlib import nullcontext

    from ..show.live import view

    try:
        with nullcontext(lambda _: None) if quiet else view() as watch:
            run.run(duration_s, watch)
    except KeyboardInterrupt:
        if run.last is None:
            raise
        return True
    return False


def _sum_up(run: Drive, as_json: bool) -> None:
    from ..show.live import show_summary

    found = run.summary()
    if found is None:
        return
    show_json({"gait": describe(run.gait)} | found.to_dict()) if as_json else show_summary(found)


@click.command()
@click.option("--board", type=click.Choice(["uno", "nano", "mega"]),
              help="Needed where the USB id does not tell.")  # fmt: skip
@click.option("--port", help="Serial port; found by its USB id unless given.")
@click.option("--project", type=click.Path(file_okay=False, path_type=Path),
              help="Folder of platformio.ini; found from here unless given.")  # fmt: skip
@AS_JSON
def flash(board: str | None, port: str | None, project: Path | None, as_json: bool) -> None:
    """Build the firmware and put it on the board, by PlatformIO, then wait for its greeting."""
    from dataclasses import asdict

    from ..robot.tools.upload import flash as build_and_upload

    try:
        hello = build_and_upload(
            board, port, project, lambda text: click.echo(text, nl=False, err=True)
        )
    except (KeyboardInterrupt, SystemExit):
        click.echo("\nthe board may hold half a program: flash it again before use", err=True)
        raise
    if as_json:
        show_json(asdict(hello))
    else:
        click.echo(
            f"the {hello.board} runs firmware {hello.firmware}, protocol {hello.protocol}; "
            "next: `serpenoid doctor`, then `serpenoid trim`"
        )


@click.command()
@PORT
@AS_JSON
def trim(port: str | None, as_json: bool) -> None:
    """Centre each servo by keys and save that on the board; the robot straightens first."""
    from dataclasses import asdict

    from ..robot.robot import Robot
    from ..robot.tools.keys import keyboard, need_terminal
    from ..robot.tools.trimming import UNATTENDED_S, Trimming, straighten

    need_terminal()
    with Robot(port, unattended_s=UNATTENDED_S) as robot:
        straighten(robot)
        work = Trimming(robot, lambda text: click.echo(text, err=True))
        with keyboard() as keys:
            work.go(keys)
    if as_json:
        show_json({"saved": not work.unsaved, "trims": [asdict(t) for t in work.trims]})


@click.command()
@PORT
@click.option("--all", "everything", is_flag=True, help="Every telemetry line, not one a second.")
def monitor(port: str | None, everything: bool) -> None:
    """Talk to the board: each line is checked, `!` stops the robot at once, Ctrl-C leaves.

    Lines from a pipe are sent one by one: `echo status | serpenoid monitor`.
    """
    from ..robot.tools.monitor import converse

    converse(port, 1 if everything else 50)


COMMANDS = (ports, doctor, flash, drive, trim, monitor)
