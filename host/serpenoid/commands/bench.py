"""The commands of `serpenoid bench`."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import click

from ..show.screen import say
from .group import Commands
from .paths import OutFolder

OUT = click.option(
    "--out",
    type=OutFolder(),
    show_default=True,
    default=Path("bench-out"),
    help="Folder for figures and numbers.",
)
SEED = click.option("--seed", type=int, default=1, show_default=True, help="Of what is drawn.")
PAGE = click.option(
    "--page",
    type=click.Path(exists=True, dir_okay=False, path_type=Path),
    help="A Markdown page whose table between the markers is renewed.",
)


@click.group(name="bench", cls=Commands)
def BENCH_GROUP() -> None:
    """Measure error against run time beside other solvers, and stability."""


def _tell(text: str) -> None:
    say(text, err=True)


@BENCH_GROUP.command()
@OUT
@click.option("--quick", is_flag=True, help="Three scenes, three rounds: less than a minute.")
@PAGE
def accuracy(out: Path, quick: bool, page: Path | None) -> None:
    """Draw error against run time of every method and its peers: accuracy.png, .csv and .json."""
    from ..bench.accuracy import files
    from ..bench.accuracy.contenders import absent
    from ..bench.accuracy.equal_error import headline, table
    from ..bench.accuracy.figure import accuracy_figure
    from ..bench.accuracy.measure import NOT_TRIED, QUICK, Effort, run
    from ..bench.page import renew_table

    for missing in absent():
        _tell(f"left out, not installed: {missing}; pip install 'serpenoid[bench]' brings it")
    rows = run(QUICK if quick else Effort(), _tell)
    out.mkdir(parents=True, exist_ok=True)
    files.write_csv(rows, out / "accuracy.csv")
    files.write_json(rows, out / "accuracy.json")
    accuracy_figure(rows, out / "accuracy.png")
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
@click.option("--quick", is_flag=True, help="A coarse map, no long chains: less than a minute.")
def stability(out: Path, quick: bool) -> None:
    """Map where each fixed step is stable, and try extreme scenes; exit status 1 on a defect."""
    from ..bench.stability.files import defects, measure_and_write, summary

    found = measure_and_write(out, quick, _tell)
    for line in summary(*found):
        say(line)
    wrong = defects(*found[:2])
    for line in wrong:
        say(f"DEFECT: {line}")
    say(f"\n{len(wrong)} defects; maps and tables in {out}")
    if wrong:
        raise SystemExit(1)


@BENCH_GROUP.command()
@OUT
def scenes(out: Path) -> None:
    """Count instructions per step of ever richer scenes: what is absent costs nothing."""
    from ..bench.cost.scenes import RUNGS, run

    rungs = run(out, _tell)
    say("instructions per RK4 step, six links (callgrind)")
    for r in rungs:
        title = RUNGS[r.rung]
        say(f"{r.formulation:10}{title:40}{r.instructions_per_step:10.0f}{r.ratio:8.2f}")
    say(f"written to {out / 'scenes.csv'}; the last column is relative to the first line")


@BENCH_GROUP.command()
@OUT
@click.option(
    "--runs",
    type=click.IntRange(1),
    default=100,
    show_default=True,
    help="Random runs of every kind.",
)
@SEED
def errors(out: Path, runs: int, seed: int) -> None:
    """Hold what random runs say of their own error against the truth; exit status 1 below 99 %."""
    import csv

    from ..bench.errors import coverage_rows, judge_class
    from ..show.report import table

    rows = coverage_rows(list(judge_class(runs, seed, _tell)))
    out.mkdir(parents=True, exist_ok=True)
    with (out / "errors.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, list(rows[0]))
        writer.writeheader()
        writer.writerows(rows)
    texts = [
        [v.replace("_", " ") if isinstance(v, str) else f"{v:.4g}" for v in row.values()]
        for row in rows
    ]
    head = [name.replace("_", " ") for name in rows[0]]
    table(f"runs whose true error is within their estimate; in {out / 'errors.csv'}", head, texts)
    if float(rows[-1]["unwarned_misses"]) > 0.01 * float(rows[-1]["runs"]):
        raise SystemExit(1)


@BENCH_GROUP.command()
@OUT
@click.option("--quick", is_flag=True, help="A ninth of the grids, short chains: some seconds.")
def steady(out: Path, quick: bool) -> None:
    """Time periodic states: the paper's grid, one gait, links, errors: steady.png and .csv."""
    from ..bench.cost.steady import measure, summary, write

    rows = measure(quick, _tell)
    write(rows, out)
    for line in summary(rows):
        say(line)
    say(f"in {out}")


def _sessions(usual: int, least: int = 1) -> Callable[[Callable[..., None]], Callable[..., None]]:
    return click.option(
        "--sessions",
        type=click.IntRange(least),
        default=usual,
        show_default=True,
        help="Simulated sessions of each kind.",
    )


def _written(found: Iterable[Any], path: Path) -> list[dict[str, Any]]:
    """Write dataclasses to a JSON file and return them as dictionaries."""
    import json
    from dataclasses import asdict

    rows = [asdict(one) for one in found]
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(rows, indent=2) + "\n")
    return rows


def _show_coverage(rows: Iterable[dict[str, Any]], title: str) -> None:
    from ..show.report import table

    names = ("ct", "cn", "ft0", "fn0", "speed", "driven")
    texts = [[row["case"], *(f"{row[name]:.1%}" for name in names)] for row in rows]
    table(title, ["case", *names], texts)


@BENCH_GROUP.command()
@OUT
@_sessions(1000, 20)
@SEED
def coverage(out: Path, sessions: int, seed: int) -> None:
    """Tell how often 95 % intervals hold the truth, over sessions taken in the virtual lab."""
    from ..bench.calibration.coverage import run
    from ..bench.calibration.figure import coverage_figure

    rows = _written(run(sessions, seed, _tell), out / "coverage.json")
    coverage_figure(rows, out / "coverage.png")
    _show_coverage(rows, f"of {sessions} sessions the interval holds the truth in; in {out}")


@BENCH_GROUP.command()
@OUT
@_sessions(1000)
@SEED
def floor(out: Path, sessions: int, seed: int) -> None:
    """Tell how often 95 % intervals hold the truth, over sessions of pushes on a floor.

    Filmed, and by tape and watch: of those a fifth of the sessions.
    """
    from ..bench.calibration.floor_coverage import run_floor

    rows = _written(run_floor(sessions, seed, _tell), out / "floor.json")
    title = f"of {sessions} sessions on a floor the interval holds the truth in; in {out}"
    _show_coverage(rows, title)


@BENCH_GROUP.command()
@OUT
@_sessions(100)
@SEED
def advise(out: Path, sessions: int, seed: int) -> None:
    """Count the readings that advice needs to the speed band of a fixed plan."""
    from ..bench.calibration.advised import ratios, run
    from ..bench.calibration.figure import advised_figure

    found = run(sessions, seed, _tell)
    advised_figure(_written(found, out / "advise.json"), out / "advise.png")
    for r in ratios(found):
        say(
            f"{r.plan} plan: {r.plan_readings:.1f} readings leave a band of {r.target:.1%}; "
            f"advised, {r.advised_readings:.1f} do ({r.ratio:.0%}; after the opening "
            f"{r.after_opening:.0%}); {r.reached} of {r.sessions} sessions got there"
        )


@BENCH_GROUP.command()
@OUT
@_sessions(100)
@SEED
@PAGE
def verdict(out: Path, sessions: int, seed: int, page: Path | None) -> None:
    """Count how often compare's verdict is right, over sessions and runs with known faults."""
    from ..bench.calibration.figure import verdict_figure
    from ..bench.calibration.verdicts import markdown, run
    from ..bench.page import renew_table

    rows = _written(run(sessions, seed, _tell), out / "verdict.json")
    verdict_figure(rows, out / "verdict.png")
    if page is not None:
        renew_table(page, "verdicts", markdown(rows))
    say(markdown(rows))
    say(f"in {out}")
