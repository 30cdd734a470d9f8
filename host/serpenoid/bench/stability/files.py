"""What the stability benchmark writes and says: CSV files, the figure, and a summary in words."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from ..rows import write_rows
from . import extremes
from . import map as stability_map
from .extremes import DEFECTS, Outcome
from .figure import shown, stability_figure
from .map import FULL, QUICK, WORDS, Cell


def measure_and_write(
    out: Path, quick: bool, tell: Callable[[str], None]
) -> tuple[list[Cell], list[Outcome]]:
    """Measure the map and the extremes, write their files into out, and return both."""
    out.mkdir(parents=True, exist_ok=True)
    cells = list(stability_map.measure(QUICK if quick else FULL, tell))
    write_rows(out / "stability_map.csv", cells)
    write_rows(out / "stability.csv", shown(cells))
    stability_figure(shown(cells), out / "stability.png")
    outcomes = list(extremes.run(quick, tell))
    write_rows(out / "stability_extremes.csv", outcomes)
    return cells, outcomes


def defects(cells: Sequence[Cell], outcomes: Sequence[Outcome]) -> list[str]:
    """Return what must not be: cells that run and grow or give no answer, and broken outcomes."""
    return [
        *(f"{WORDS[3]}: {cell}" for cell in cells if cell.kind == 3),
        *(str(one) for one in outcomes if one.outcome in DEFECTS),
    ]


def summary(cells: Sequence[Cell], outcomes: Sequence[Outcome]) -> Iterator[str]:
    """Yield the lines that a person reads: counts of the maps, and the extremes."""
    for method in dict.fromkeys(cell.method for cell in cells):
        counts = Counter(WORDS[cell.kind] for cell in cells if cell.method == method)
        yield f"{method}: " + ", ".join(f"{n} {word}" for word, n in counts.items())
    yield f"\n{'extreme scene':32} {'method':20} {'outcome':13} {'stated':>8} {'error':>8} seconds"
    for o in outcomes:
        numbers = f"{o.stated:8.1e} {o.error:8.1e} {o.time_s:.2g}" if o.time_s >= 0 else ""
        yield f"{o.scene:32} {o.method:20} {o.outcome:13} {numbers or o.said}"
