"""The command `serpenoid bench`: error against run time, stability, and what a scene costs."""

from __future__ import annotations

import dataclasses
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..show.screen import say
from .declare import Command, directory, flag, option

if TYPE_CHECKING:
    from ..bench.extremes import Outcome
    from ..bench.stability_map import Cell


def _tell(text: str) -> None:
    say(text, err=True)


@click.command(cls=Command)
@option("--out", "Folder for figures and numbers.", type=directory, default=Path("bench-out"))
@flag("--quick", "Three scenes and a coarse map, in a quarter of a minute; else four minutes.")
def bench(out: Path, quick: bool) -> None:
    """Measure every method beside SciPy: error against run time, stability, and costs.

    Exit status 1 where a run hangs, has a NaN or is silently wrong.
    """
    from ..base.files import write_csv
    from ..bench import extremes, scenes, stability_map, work_precision
    from ..bench.work_precision_figure import work_precision_figure

    def save(name: str, rows: Sequence[Any]) -> None:
        header = [field.name for field in dataclasses.fields(rows[0])]
        write_csv(out / name, header, [list(dataclasses.astuple(row)) for row in rows])

    out.mkdir(parents=True, exist_ok=True)
    _tell("what each term of a scene costs ...")
    costs = list(scenes.measure(quick))
    save("costs.csv", costs)
    rows = list(work_precision.measure(quick, _tell))
    work_precision.write_rows(out / "accuracy.csv", rows)
    work_precision_figure(rows, out / "accuracy.png", work_precision.machine())
    grid = stability_map.QUICK if quick else stability_map.FULL
    cells = list(stability_map.measure(grid, _tell))
    save("stability.csv", cells)
    stability_map.stability_figure(cells, out / "stability.png")
    outcomes = list(extremes.measure(quick, _tell))
    save("extremes.csv", outcomes)

    say(f"Milliseconds a simulated second at an error of 1e-6:\n\n{work_precision.table(rows)}\n")
    say("Time of a Runge-Kutta step, 6 links, and its ratio to the plain scene:")
    for one in costs:
        say(f"{one.formulation:10}{one.scene:28}{one.step_us:7.2f} us{one.ratio:7.2f}")
    for method in dict.fromkeys(cell.method for cell in cells):
        words = Counter(stability_map.WORDS[cell.kind] for cell in cells if cell.method == method)
        say(f"\n{method}: " + ", ".join(f"{count} {word}" for word, count in words.items()))
    say("\nExtreme scenes: " + ", ".join(f"{n} {w}" for w, n in _outcomes(outcomes).items()))
    defects = count_defects(cells, outcomes)
    say("Defects: " + ", ".join(f"{word} {count}" for word, count in defects.items()))
    say(f"Figures and numbers are in {out}")
    if any(defects.values()):
        raise SystemExit(1)


def _outcomes(outcomes: Sequence[Outcome]) -> Counter[str]:
    return Counter(one.outcome for one in outcomes)


def count_defects(cells: Sequence[Cell], outcomes: Sequence[Outcome]) -> dict[str, int]:
    """Return how many cells and extreme scenes show each defect: all must be 0."""
    from ..bench.extremes import DEFECTS

    found = _outcomes(outcomes)
    counts = {word: found[word] for word in DEFECTS}
    counts["SILENTLY WRONG"] += sum(cell.kind == 3 and not cell.note for cell in cells)
    counts["HANG"] += len({cell.note for cell in cells if cell.note})
    return counts
