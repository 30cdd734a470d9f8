"""What the stability benchmark writes and says: CSV files, figures, and a summary in words."""

from __future__ import annotations

import csv
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any

from . import extremes, free_snake
from . import map as stability_map
from .extremes import DEFECTS, Outcome
from .figure import WORDS, kind, overview, shown, stability_figure
from .free_snake import Drift
from .map import FULL, QUICK, Cell


def _write(rows: Sequence[Any], path: Path) -> None:
    """Write dataclasses of one kind, one a line."""
    with path.open("w", newline="") as file:
        names = [f.name for f in fields(rows[0])]
        writer: csv.DictWriter[str] = csv.DictWriter(file, names)
        writer.writeheader()
        writer.writerows(asdict(row) for row in rows)


def write_cells(cells: Sequence[Cell], path: Path) -> None:
    """Write cells of a map in short: growth and limit to three digits."""
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(_SHORT)
        for c in cells:
            writer.writerow(
                [
                    c.method,
                    c.links,
                    f"{c.damping_n_s_m:g}",
                    f"{c.stiffness_n_m:.4g}",
                    f"{c.dt_s:.4g}",
                    f"{c.growth:.3g}",
                    f"{c.limit_s:.3g}",
                    int(c.refused),
                    c.note,
                ]
            )


def read_cells(path: Path) -> list[Cell]:
    """Return the cells of a file that write_cells wrote."""
    with path.open(newline="") as file:
        return [
            Cell(
                row["method"],
                int(row["links"]),
                float(row["damping_n_s_m"]),
                float(row["stiffness_n_m"]),
                float(row["dt_s"]),
                float(row["growth"]),
                float(row["limit_s"]),
                row["refused"] == "1",
                row["note"],
            )
            for row in csv.DictReader(file)
        ]


_SHORT = [f.name for f in fields(Cell)]


def measure_and_write(
    out: Path, quick: bool, tell: Callable[[str], None]
) -> tuple[list[Cell], list[Outcome], list[Drift]]:
    """Measure map, extremes and free snake, write their files into out, and return all three."""
    out.mkdir(parents=True, exist_ok=True)
    cells = stability_map.measure(QUICK if quick else FULL, tell)
    _write(cells, out / "stability_map.csv")
    for method in stability_map.fixed_step_methods():
        stability_figure(cells, method, out / f"stability_{method}.png")
    write_cells(shown(cells), out / "stability.csv")
    overview(cells, out / "stability.png")
    outcomes = extremes.run(quick, tell)
    _write(outcomes, out / "stability_extremes.csv")
    drifts = free_snake.run(10**4 if quick else 10**5, tell)
    _write(drifts, out / "stability_free_snake.csv")
    return cells, outcomes, drifts


def defects(cells: Sequence[Cell], outcomes: Sequence[Outcome]) -> list[str]:
    """Return what must not be: cells that run and grow or give no answer, and broken outcomes."""
    return [
        *(f"{WORDS[3]}: {cell}" for cell in cells if kind(cell) == 3),
        *(str(one) for one in outcomes if one.outcome in DEFECTS),
    ]


def summary(
    cells: Sequence[Cell], outcomes: Sequence[Outcome], drifts: Sequence[Drift]
) -> Iterator[str]:
    """Yield the lines that a person reads: counts of the maps, extremes, drifts."""
    for method in dict.fromkeys(cell.method for cell in cells):
        counts = Counter(WORDS[kind(cell)] for cell in cells if cell.method == method)
        yield f"{method}: " + ", ".join(f"{n} {word}" for word, n in counts.items())
    yield f"\n{'extreme scene':32} {'method':20} {'outcome':13} {'stated':>8} {'error':>8} seconds"
    for o in outcomes:
        numbers = f"{o.stated:8.1e} {o.error:8.1e} {o.time_s:.2g}" if o.time_s >= 0 else ""
        yield f"{o.scene:32} {o.method:20} {o.outcome:13} {numbers or o.said}"
    yield "\nfree snake, changes relative to the start: energy, momentum, angular momentum"
    for d in drifts:
        numbers = f"{d.energy:8.1e} {d.momentum:8.1e} {d.angular_momentum:8.1e}"
        who = f"{d.method}, {d.formulation}, {d.steps} steps of {d.dt_s:g} s"
        yield f"{who:55} {d.said or numbers}"
