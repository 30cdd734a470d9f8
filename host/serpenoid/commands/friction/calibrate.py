"""The commands `serpenoid calibrate ...`: begin, take, resume and correct a session."""

from __future__ import annotations

from pathlib import Path

import click

from ...base.checks import count_text
from ...base.errors import BadInput
from ...show.screen import say
from ..declare import EXISTING, option
from ..group import Commands
from ..options import show_json
from .calibrate_new import new
from .calibrate_push import push


@click.group(cls=Commands, usual="take")
def calibrate() -> None:
    """Measure friction on a floor or a treadmill: `calibrate new DIR`, then `calibrate DIR`.

    With `new --on floor` you push the robot and film how it rolls to a stop. Run `calibrate DIR`
    again at any time: it continues. Every reading is on the disk before the next is asked for, and
    nothing is overwritten. Correct mistyped settings in DIR/session.toml.

    `calibrate DIR` takes --port (a robot that bends and steers itself) and --script: see
    `serpenoid calibrate take --help`. `calibrate status DIR` shows the next step.
    """


calibrate.add_command(new)
calibrate.add_command(push)


@calibrate.command()
@option("--script", "Script such as plan.toml, which answers in place of a person.", type=EXISTING)
@option(
    "--port",
    "Serial port of a robot that bends and drives itself, or `virtual`; unless given, by hand.",
)
def take(
    folder: Path,
    script: Path | None,
    port: str | None,
) -> None:
    """Start or resume a session; `serpenoid calibrate DIR` is short for this."""
    if script is not None and port is not None:
        raise click.UsageError("give one of --script and --port")
    if script is None:
        from .calibrate_person import with_a_person

        return with_a_person(folder, port)
    from ...session.journal import PROGRAM, Journal
    from ...taking.script import run_script

    with Journal(folder) as journal:
        journal.event("start", detail=f"{PROGRAM}, script {script.name}")
        added = run_script(journal, script, lambda text: say(text, err=True))
        journal.event("end")
        return say(f"{count_text(added, 'reading')} added; {journal.session}")


@calibrate.command()
@click.argument("kind")
@click.argument("cells", nargs=-1, metavar="NAME=VALUE...")
@option("--replaces", "Number of the reading that this one replaces.", default=0)
@option("--comment", "Remark on the reading.", default="")
def add(
    folder: Path,
    kind: str,
    cells: tuple[str, ...],
    replaces: int,
    comment: str,
) -> None:
    """Add one reading, such as `station lambda_deg=0 incline_deg=2.3 belt_speed_m_s=1.6km/h`."""
    from ...session.journal import Journal
    from ...taking.parse_number import typed_cells

    typed = dict[str, str]()
    for cell in cells:
        name, equals, text = cell.partition("=")
        if not equals:
            raise BadInput(f"{cell!r} is not NAME=VALUE")
        typed[name] = text
    with Journal(folder) as journal:
        values = typed_cells(kind, typed, journal.session.setup)
        number = journal.add(kind, values, replaces=replaces, comment=comment)
    say(f"reading {number} is kept" + (f"; reading {replaces} is not" if replaces else ""))


@calibrate.command()
@click.argument("number", type=int)
@option("--reason", "Reason not to use it.", default="")
def void(folder: Path, number: int, reason: str) -> None:
    """Mark a reading as void, so that it is not used; its line stays in the file."""
    from ...session.journal import Journal

    with Journal(folder) as journal:
        journal.event("void", number, reason)
    say(f"reading {number} is void")


@calibrate.command()
def status(folder: Path, as_json: bool) -> None:
    """Show a session's progress, its readings and the next step; writes nothing."""
    from ...session.folder import read_session
    from ...show.session import table
    from ...taking.procedure import next_step, progress

    session = read_session(folder)
    parts, step = progress(session), next_step(session)
    if as_json:
        return show_json(table.as_dict(session, parts, step.say))
    table.show(session, parts)
    say(f"next: {step.say}")
    return None
