"""What a run records, and its file: every column under a name that says whose it is."""

from __future__ import annotations

import numpy as np
import pytest
import serpenoid as sn
from robots import PAPER, VISCOUS


def test_every_column(tmp_path) -> None:
    scene = sn.Scene(
        sn.Robot(3, 1.0, 0.12),
        VISCOUS,
        sn.Gait(0.5, 1.4, 5.0),
        duration_s=0.05,
        record=("joints", "friction", "energy"),
    )
    run = sn.simulate(scene)
    run.to_csv(tmp_path / "run.csv")
    table = np.genfromtxt(tmp_path / "run.csv", delimiter=",", names=True)
    for name, of in (
        ("t_s", run.t_s),
        ("x1_m", run.x_m[:, 0]),
        ("vy3_m_s", run.vy_m_s[:, 2]),
        ("joint_torque2_nm", run.joint_torque_nm[:, 1]),
        ("friction_y2_n", run.friction_y_n[:, 1]),
        ("friction_heat_j", run.energy_j[:, 4]),
    ):
        assert table[name] == pytest.approx(of, rel=1e-12, abs=1e-15), name
    assert len(table.dtype.names) == 1 + 3 * 6 + 2 * 3 + 3 * 2 + 7


def test_a_run_is_shown_by_a_sentence() -> None:
    run = sn.simulate(sn.Scene(PAPER, VISCOUS, sn.Gait(0.5, 1.4, 5.0), duration_s=0.1))
    assert repr(run) == f"<Run: {run.in_words()}>"
