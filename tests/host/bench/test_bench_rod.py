"""PyElastica's gait beside the exact model: rows and files; where it is installed, the speed."""

from __future__ import annotations

import csv
import math
from dataclasses import replace
from pathlib import Path

import pytest
import serpenoid as sn
from serpenoid.bench.cost.rod import RodRow, write


def test_ratios_and_file(tmp_path: Path) -> None:
    row = RodRow("paper", 0.294, 0.28, 7, 2e-3, 1e-3, 2.0, 4e-5)
    assert row.apart == pytest.approx(0.05)
    assert row.times == pytest.approx(5e4)
    write([row, replace(row, gait="slow")], tmp_path / "new" / "rod.csv")
    with (tmp_path / "new" / "rod.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [r["gait"] for r in rows] == ["paper", "slow"]
    assert float(rows[0]["exact_s"]) == 4e-5


@pytest.mark.slow
def test_a_rod_crawls_as_fast_as_the_exact_model_with_its_inertia() -> None:
    pytest.importorskip("elastica", reason="an optional peer: pip install 'serpenoid[bench]'")
    from serpenoid.bench.peers.elastica_peer import follow
    from serpenoid.bench.peers.rod_robot import as_rod_sees_it

    robot, ground = sn.Robot(6, 1.0, 0.12), sn.Ground(0.1, 10.0)
    gait = sn.Gait(math.radians(30), math.radians(80), 5.0)
    exact = sn.steady_gait(as_rod_sees_it(robot), ground, gait).speed_m_s
    found = follow(robot, ground, gait, 2e-4, 3e-3)
    assert found.speed_m_s == pytest.approx(exact, rel=1e-2)
    assert found.bend_error_rad < 0.02
