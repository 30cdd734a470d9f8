"""`serpenoid doctor`: what keeps the robot from working."""

from __future__ import annotations

import click

from ...show.screen import say
from ..options import AS_JSON, show_json
from .port import PORT

MARKS = {"ok": "ok  ", "note": "note", "fix": "FIX "}


@click.command()
@PORT
@click.option(
    "--listen-s",
    type=click.FloatRange(0, 600),
    default=3.0,
    show_default=True,
    help="How long to listen to the board.",
)
@AS_JSON
def doctor(port: str | None, listen_s: float, as_json: bool) -> None:
    """Find what keeps the robot from working, and say the fix; nothing moves.

    Exit status 0 if all is well, 1 if there is something to fix.
    """
    from ...robot.tools.doctor import examine

    findings = []
    for finding in examine(port, listen_s):
        findings.append(finding)
        if not as_json:
            say(f"{MARKS[finding.mark]}  {finding.name}: {finding.found}")
            if finding.fix:
                say(f"      -> {finding.fix}")
    well = all(finding.mark != "fix" for finding in findings)
    if as_json:
        show_json({"well": well, "findings": [finding.to_dict() for finding in findings]})
    if not well:
        raise SystemExit(1)
