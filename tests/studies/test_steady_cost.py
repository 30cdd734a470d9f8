"""The cost of periodic states: rows, ratios and files, from a measurement that is made up."""

from __future__ import annotations

import csv
import math
from pathlib import Path

from steady_cost import CASES, Cost, summary, write


def made_up() -> list[Cost]:
    rows = []
    for ground in CASES:
        rows += [
            Cost("grid", ground, 6, 1e-6, math.nan, 1e-4),
            Cost("run", ground, 6, 1e-3, math.nan, 2e-3),
            Cost("gait", ground, 6, 1e-8, math.nan, 5e-5),
        ]
        rows += [Cost("links", ground, n, 1e-6, math.nan, 1e-5 * n) for n in (3, 6, 12)]
        rows += [Cost("error", ground, 6, r, r / 10, -1e-5 * math.log10(r)) for r in (1e-2, 1e-4)]
    return rows


def test_ratios_are_of_this_run() -> None:
    lines = summary(made_up())
    assert "100 us a gait, 0.450 s for 4500" in lines[0]
    assert "50 us" in lines[1]
    assert "20 times" in lines[1]


def test_files(tmp_path: Path) -> None:
    write(made_up(), tmp_path)
    with (tmp_path / "steady.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 16
    assert float(rows[0]["seconds_per_gait"]) == 1e-4
