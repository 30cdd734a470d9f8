"""The cost of periodic states: rows, ratios and files, from a measurement that is made up."""

from __future__ import annotations

import csv
import math
from pathlib import Path

import pytest
from serpenoid.bench.cost.steady import (
    CASES,
    Cost,
    dry_products,
    summary,
    viscous_products,
    write,
)


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


@pytest.mark.parametrize("ground", CASES)
def test_the_floor_is_told(ground: str) -> None:
    floor = Cost("grid floor", ground, 6, 1e-6, math.nan, 2e-5)
    line = summary([*made_up(), floor])[-1]
    assert f"{ground}: grid 450 ms, 5.0 times its floor of 90 ms" in line


def test_one_gait_and_a_process_have_floors_of_their_own() -> None:
    rows = [
        Cost(what, "viscous", 6, 1e-6, math.nan, seconds)
        for what, seconds in (("gait floor", 2e-6), ("process", 1e-4), ("process floor", 5e-5))
    ]
    gait, whole = summary([*made_up(), *rows])[-2:]
    assert "gait 50 us, 25.0 times its floor of 2 us" in gait
    assert "process 450 ms, 2.0 times its floor of 225 ms" in whole


def test_the_floors_count_what_they_say() -> None:
    assert viscous_products() == pytest.approx(14_000, rel=0.03)
    assert viscous_products() - viscous_products(powers=False) == pytest.approx(3500, rel=0.02)
    assert dry_products() == pytest.approx(19 * 7000, rel=0.1)


def test_files(tmp_path: Path) -> None:
    write(made_up(), tmp_path)
    with (tmp_path / "steady.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 16
    assert float(rows[0]["seconds_per_gait"]) == 1e-4
    assert (tmp_path / "steady.png").stat().st_size > 10_000
