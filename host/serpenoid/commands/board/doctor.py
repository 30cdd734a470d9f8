"""`serpenoid doctor`: what keeps the robot from working."""

from __future__ import annotations

from pathlib import Path

import click

from ...show.screen import say
from ..declare import flag, option
from ..options import AS_JSON, show_json
from ..paths import out_file
from .port import PORT

MARKS = {"ok": "ok  ", "note": "note", "fix": "FIX "}


@click.command()
@PORT
@option(
    "--listen-s", "How long to listen to the board.", type=click.FloatRange(0.2, 600), default=3.0
)
@option(
    "--report",
    "Collect in some five minutes what board and host tell, for docs/first_day.md.",
    type=out_file(".json"),
)
@flag("--move", "The report's limp test and slow gait, too: it asks.")
@AS_JSON
def doctor(
    port: str | None, listen_s: float, report: Path | None, move: bool, as_json: bool
) -> None:
    """Find what keeps the robot from working, and say the fix; nothing moves without --move.

    Exit status 0 if all is well, 1 if there is something to fix.
    """
    import json

    from ...model.files import write_text
    from ...robot.tools.doctor import examine
    from ...robot.tools.first_day import measure
    from ...robot.tools.keys import need_terminal

    if move:
        if not report:
            raise click.UsageError("--move adds to a report; name its file with --report FILE")
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
    if report:
        say("measuring for some five minutes ...", err=True)
        facts = measure(port, (lambda text: click.confirm(text, err=True)) if move else None)
        facts["findings"] = [vars(finding) for finding in findings]
        write_text(report, json.dumps(facts, indent=2))
        well = well and "failure" not in facts
        remarks = [f"{name}: {facts[name]}" for name in ("left_out", "failure") if name in facts]
        say("\n".join([*remarks, f"wrote {report}"]), err=True)
    if not well:
        raise SystemExit(1)
