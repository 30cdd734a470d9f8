"""The commands of `serpenoid bench`."""

from __future__ import annotations

from pathlib import Path

import click

from ..show.screen import say
from .declare import EXISTING, directory, flag, option
from .group import Commands

OUT = option("--out", "Folder for figures and numbers.", type=directory, default=Path("bench-out"))


@click.group(name="bench", cls=Commands)
def BENCH_GROUP() -> None:
    """Measure error against run time beside SciPy's solvers, and stability."""


def _tell(text: str) -> None:
    say(text, err=True)


@BENCH_GROUP.command()
@OUT
@flag("--quick", "Three scenes, three rounds: less than a minute.")
@option("--page", "A Markdown page whose table between the markers is renewed.", type=EXISTING)
def accuracy(out: Path, quick: bool, page: Path | None) -> None:
    """Draw error against run time of every method and SciPy's: accuracy.png, .csv and .json."""
    from ..bench.accuracy.equal_error import headline, table
    from ..bench.accuracy.figure import write_all
    from ..bench.accuracy.measure import NOT_TRIED, QUICK, Effort, run
    from ..bench.rows import renew_table

    rows = run(QUICK if quick else Effort(), _tell)
    write_all(rows, out)
    if page:
        renew_table(page, "accuracy", table(rows))
    failed = [row for row in rows if row.error is None]
    for row in failed:  # all stand in the files; here those that were tried
        if row.note.startswith(NOT_TRIED):
            continue
        say(f"failed: {row.scene}, {row.method}, {row.kind} {row.setting:g}: {row.note}")
    say(f"\n{table(rows)}\n")
    for line in headline(rows):
        if "ratio" in line:
            say("{scene} at {error:g}: {ours} {ratio:.3g} times as fast as {peer}".format(**line))
    say(f"{len(rows)} rows, {len(failed)} without a result; in {out}")


@BENCH_GROUP.command()
@OUT
@flag("--quick", "A coarse map, no long chains: less than a minute.")
def stability(out: Path, quick: bool) -> None:
    """Map where each fixed step is stable, and try extreme scenes; exit status 1 on a defect."""
    from ..bench.stability.figure import defects, measure_and_write, summary

    measured = measure_and_write(out, quick, _tell)
    for line in summary(*measured):
        say(line)
    wrong = defects(*measured)
    for line in wrong:
        say(f"DEFECT: {line}")
    say(f"\n{len(wrong)} defects; maps and tables in {out}")
    if wrong:
        raise SystemExit(1)


@BENCH_GROUP.command()
@OUT
def scenes(out: Path) -> None:
    """Count instructions per step of ever richer scenes."""
    from ..bench.scenes import run

    rungs = run(out, _tell)
    say("instructions per RK4 step, six links (callgrind)")
    for r in rungs:
        counts = f"{r.instructions_per_step:10.0f}{r.ratio_to_plain:8.2f}"
        say(f"{r.formulation:10}{r.rung:30}{counts}")
    say(f"written to {out / 'scenes.csv'}; the last column is relative to the plain scene")
