"""The commands that deal with a robot: ports, doctor, flash, drive, trim, monitor."""

from __future__ import annotations

import click

from ..options import AS_JSON, show_json

PORT = click.option(
    "--port", help="Serial port; found by its USB id unless given. `virtual` needs no robot."
)
MARKS = {"ok": "ok  ", "note": "note", "fix": "FIX "}


@click.command()
@AS_JSON
def ports(as_json: bool) -> None:
    """List the serial ports: which may be the robot, and who has them open."""
    from .culprit import why_no_port
    from .ports import port_states

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
    from .doctor import examine

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


COMMANDS = (ports, doctor)
