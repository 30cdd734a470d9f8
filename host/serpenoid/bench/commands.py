"""The commands of `serpenoid bench`."""

from __future__ import annotations

from pathlib import Path

import click


@click.group(name="bench")
def BENCH_GROUP() -> None:
    """Measure error against run time, beside what else could do the work."""


@BENCH_GROUP.command()
@click.option("--out", type=click.Path(path_type=Path), default=Path("bench-out"))
@click.option("--quick", is_flag=True, help="Only the 3-link and 6-link scenes, three rounds.")
def accuracy(out: Path, quick: bool) -> None:
    """Write accuracy.csv: error and median time of every method and step, viscous scenes."""
    from importlib.util import find_spec

    from .accuracy import run

    names = ("paper3", "paper3_k1e3", "paper6", "paper6_k1e3") if quick else ()
    rows = run(out, names, 3 if quick else 5)
    for row in rows:
        click.echo("  ".join(str(value) for value in row.values()))
    if not find_spec("numba"):
        click.echo("left out, for want of numba: every peer; pip install 'serpenoid[bench]'")
    click.echo(f"{len(rows)} rows in {out / 'accuracy.csv'}")
