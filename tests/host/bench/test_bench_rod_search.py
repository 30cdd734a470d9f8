"""The search by a rod: kept, gone on with, beside the exact model; a rod only where installed."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import pytest
import serpenoid as sn
from serpenoid.bench.cost import rod_search as searching
from serpenoid.bench.cost.rod_log import Log, Tried
from serpenoid.model.errors import BadInput

NO_CMA = "an optional peer: pip install 'serpenoid[bench]'"


def stand_in(number: int, gait: sn.Gait) -> Tried:
    """Answer for the rod: the exact model's speed, and a second for it."""
    speed = searching.exact_speed(gait)
    return Tried(number, gait.omega_rad_s, gait.alpha_rad, gait.beta_rad, speed, 5, 1e-3, 1.0)


def gait(k: int) -> sn.Gait:
    return sn.Gait(0.5 + 0.01 * k, 1.0, 5.0)


def test_what_a_rod_followed_is_not_followed_again(tmp_path: Path) -> None:
    path, asked = tmp_path / "runs.csv", []

    def follow(number: int, gait: sn.Gait) -> Tried:
        asked.append(number)
        return replace(stand_in(number, gait), speed_m_s=math.nan if number == 2 else 0.1)

    log = Log(path, follow)
    first = [log.tried(gait(k)) for k in range(3)]
    assert [before for _, before in first] == [False] * 3
    path.write_text(path.read_text() + "4,5.0,0.5")  # cut off while it was written
    again = Log(path, follow)
    told = [again.tried(gait(k)) for k in range(4)]
    assert [before for _, before in told] == [True] * 3 + [False]
    assert asked == [1, 2, 3, 4]
    assert [row.number for row, _ in told] == [1, 2, 3, 4]
    assert math.isnan(told[1][0].speed_m_s)
    assert "burst" in told[1][0].told
    assert len(path.read_text().splitlines()) == 5


def test_another_searchs_file_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "runs.csv"
    Log(path, stand_in).tried(gait(0))
    with pytest.raises(BadInput, match=r"another search: run 1 was .*name another folder"):
        Log(path, stand_in).tried(gait(1))
    path.write_text("a,b\n1,2\n")
    with pytest.raises(BadInput, match="not a search's log"):
        Log(path, stand_in)


def test_the_grid_finds_the_fastest_gait_of_a_finer_one() -> None:
    """Brute force over a hundred times as many shapes finds none faster."""
    found, gaits = searching.zoomed_grid(5.0)
    many = sn.sweep(
        searching.as_rod_sees_it(searching.PAPER), searching.VISCOUS, omega_rad_s=[5.0],
        alpha_rad=[0.05 + 0.0163 * k for k in range(120)],
        beta_rad=[0.1 + 0.0226 * k for k in range(120)], powers=False,
    ).speed_m_s  # fmt: skip
    assert gaits == 1024
    assert searching.exact_speed(found) >= many.max()
    assert searching.exact_speed(found) == pytest.approx(many.max(), rel=2e-3)


def test_an_interrupted_search_ends_as_if_it_had_not_been(tmp_path: Path) -> None:
    pytest.importorskip("cma", reason=NO_CMA)
    told: list[str] = []
    whole = searching.search(tmp_path / "whole.csv", 30, 3, told.append, follow=stand_in)

    def stopped(number: int, gait: sn.Gait) -> Tried:
        if number == 9:
            raise KeyboardInterrupt
        return stand_in(number, gait)

    with pytest.raises(KeyboardInterrupt):
        searching.search(tmp_path / "two.csv", 30, 3, told.append, follow=stopped)
    told.clear()
    two = searching.search(tmp_path / "two.csv", 30, 3, told.append, follow=stand_in)
    assert sum("from the file" in line for line in told) == 8
    assert [(f.gaits, f.alpha_rad, f.beta_rad, f.rod_m_s) for f in two] == [
        (f.gaits, f.alpha_rad, f.beta_rad, f.rod_m_s) for f in whole
    ]
    rod, same, grid = whole
    assert (rod.gaits, rod.seconds, rod.ended) == (30, 30.0, False)
    assert (rod.alpha_rad, rod.beta_rad) == (same.alpha_rad, same.beta_rad)
    assert 0.95 * grid.exact_m_s < rod.exact_m_s <= grid.exact_m_s
    assert "more runs go on with it" in searching.summary(whole)[-1]


def test_cma_es_alone_ends_at_the_grids_gait() -> None:
    pytest.importorskip("cma", reason=NO_CMA)
    found, gaits, done = searching.cma_es(searching.exact_speed, 5.0, 10_000, 1)
    grid, _ = searching.zoomed_grid(5.0)
    assert done
    assert gaits < 400
    assert searching.exact_speed(found) == pytest.approx(searching.exact_speed(grid), rel=1e-3)


def test_a_burst_rods_speed_counts_for_nothing() -> None:
    pytest.importorskip("cma", reason=NO_CMA)

    def speed(gait: sn.Gait) -> float:
        return math.nan if gait.alpha_rad > 0.8 else gait.alpha_rad

    found, _, _ = searching.cma_es(speed, 5.0, 60, 1)
    assert 0.7 < found.alpha_rad <= 0.8
