"""Sweeps: every gait as if alone, the same bits for any threads, axes, files, interruption."""

from __future__ import annotations

import csv
import math
from pathlib import Path

import numpy as np
import pytest
import serpenoid as sn
from command_line import answer
from refusals import refused
from robots import BINGHAM, OF_2005, PAPER, VISCOUS

GRID = {"alpha_rad": [0.4, 0.9, 1.2], "beta_rad": [0.5, 1.3], "omega_rad_s": [1.0, 5.0, 9.0]}
NAMES = sn.Sweep.__match_args__[3:13]  # figures of a gait


@pytest.mark.parametrize(("robot", "ground"), [(PAPER, VISCOUS), (OF_2005, BINGHAM)])
def test_any_number_of_threads_gives_the_same_bits(robot: sn.Robot, ground: sn.Ground) -> None:
    one = sn.sweep(robot, ground, **GRID, rtol=1e-4, threads=1)
    for threads in (2, 5):
        many = sn.sweep(robot, ground, **GRID, rtol=1e-4, threads=threads)
        for name in NAMES:
            assert np.array_equal(getattr(one, name), getattr(many, name)), name


def test_every_entry_says_how_good_it_is() -> None:
    grid = sn.sweep(OF_2005, BINGHAM, **GRID, rtol=1e-4)
    for i, j, k in np.ndindex(grid.speed_m_s.shape):
        gait = sn.Gait(GRID["alpha_rad"][i], GRID["beta_rad"][j], GRID["omega_rad_s"][k])
        s = sn.steady_gait(OF_2005, BINGHAM, gait, rtol=1e-6)
        scale = max(s.speed_m_s, 1e-4 * gait.omega_rad_s * 6 * 0.076)
        assert grid.error_estimate[i, j, k] <= 1e-4
        assert abs(grid.speed_m_s[i, j, k] - s.speed_m_s) <= 2e-4 * scale
        if s.settling_time_s > 0.2 * gait.period_s:  # below, nothing is left after one cycle
            assert grid.settling_time_s[i, j, k] == pytest.approx(s.settling_time_s, rel=0.05)


def test_progress_counts_every_gait_and_may_end_the_sweep() -> None:
    done: list[int] = []
    sn.sweep(PAPER, VISCOUS, **GRID, progress=done.append)
    assert sum(done) == 18

    class Enough(Exception):
        pass

    def stop(_done: int) -> None:
        raise Enough

    with pytest.raises(Enough):
        sn.sweep(PAPER, VISCOUS, **GRID, progress=stop)


def test_files_hold_the_sweep(tmp_path: Path) -> None:
    typed = "sweep --robot paper --alpha-deg 20:60:20 --beta-deg 30:75:45 --omega-rad-s 1:9:4"
    for suffix in ("csv", "npz"):
        values = answer(f"{typed} --out {tmp_path}/s.{suffix}")
    with np.load(tmp_path / "s.npz") as file:
        assert file["settling_time_s"].tolist() == values["settling_time_s"]
        assert file["omega_rad_s"].tolist() == values["omega_rad_s"] == [1.0, 5.0, 9.0]
    assert values["alpha_deg"] == pytest.approx([20, 40, 60])
    with (tmp_path / "s.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 18
    last = rows[-1]
    assert float(last["frequency_hz"]) == pytest.approx(9.0 / math.tau)
    assert float(last["alpha_deg"]) == pytest.approx(60.0)
    assert float(last["abs_power_w"]) == values["abs_power_w"][-1][-1][-1]
    assert last["converged"] == "1"


def test_the_fastest_gait_and_the_cheapest_metre_come_first() -> None:
    grid = sn.sweep(OF_2005, BINGHAM, **GRID, rtol=1e-4)
    fastest, cheapest = grid.best(), grid.best(per_metre=True)
    assert fastest is not None
    assert cheapest is not None
    assert fastest.speed_m_s == grid.speed_m_s.max()
    state = sn.steady_gait(OF_2005, BINGHAM, cheapest.gait)
    assert cheapest.energy_j_m == pytest.approx(state.positive_power_w / state.speed_m_s, rel=1e-3)
    assert cheapest.energy_j_m <= (grid.positive_power_w / grid.speed_m_s).min() * (1 + 1e-9)
    assert repr(grid) == f"<Sweep: {grid.in_words()}>"
    assert "Fastest: " in grid.in_words()
    assert grid.in_words().endswith("All settle.")
    still = sn.sweep(PAPER, VISCOUS, alpha_rad=0.0, beta_rad=1.0, omega_rad_s=1.0)
    assert still.best() is None


def test_bad_input_is_named() -> None:
    with refused("threads is 0; it must be a whole number from 1"):
        sn.sweep(PAPER, VISCOUS, **GRID, threads=0)
    with refused("rtol"):
        sn.sweep(PAPER, BINGHAM, **GRID, rtol=1e-9)
