"""Joints with amplitudes and phases of their own: the solver, a run in time, and refusals."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import serpenoid as sn
from refusals import refused
from robots import BINGHAM, OF_2005, PAPER, VISCOUS

D = math.pi / 180
GAIT = sn.Gait(40 * D, 70 * D, 4.0)
OWN = replace(GAIT, joint_gain=(0.9, 1.1, 1.0, 0.8, 1.05), joint_shift_rad=(0.1, -0.1, 0, 0.2, 0))


@pytest.mark.parametrize(("robot", "ground"), [(PAPER, VISCOUS), (OF_2005, BINGHAM)])
def test_one_gain_for_all_is_amplitude_and_one_shift_is_nothing(robot, ground) -> None:
    less = sn.steady_gait(robot, ground, replace(GAIT, alpha_rad=0.9 * GAIT.alpha_rad))
    same = sn.steady_gait(robot, ground, replace(GAIT, joint_gain=[0.9] * 5))
    late = sn.steady_gait(robot, ground, replace(GAIT, joint_shift_rad=[0.3] * 5))
    assert same.speed_m_s == pytest.approx(less.speed_m_s, rel=1e-5)
    assert late.speed_m_s == pytest.approx(sn.steady_gait(robot, ground, GAIT).speed_m_s, rel=1e-5)


@pytest.mark.parametrize(
    ("robot", "ground", "method", "rel"),
    [(PAPER, VISCOUS, "rk4", 1e-7), (OF_2005, BINGHAM, "nonsmooth", 1e-4)],
)
def test_the_solved_state_is_where_a_run_stays(robot, ground, method, rel) -> None:
    found = sn.steady_gait(robot, ground, OWN)
    scene = sn.Scene(
        robot,
        ground,
        OWN,
        start="steady",
        method=method,
        dt_s=OWN.period_s / 800,
        duration_s=OWN.period_s,
        record_every=800,
    )
    run = sn.simulate(scene)
    way = np.hypot(*(np.ptp(v.mean(axis=1)[[0, -1]]) for v in (run.x_m, run.y_m)))
    assert way / OWN.period_s == pytest.approx(found.speed_m_s, rel=rel)
    plain = sn.steady_gait(robot, ground, GAIT)
    assert abs(found.speed_m_s / plain.speed_m_s - 1) > 0.02


def test_refusals_and_files(tmp_path) -> None:
    scene = sn.Scene(PAPER, VISCOUS, OWN, method="rk4", dt_s=1e-3, duration_s=1.0)
    sn.save_scene(scene, tmp_path / "scene.toml")
    assert sn.load_scene(tmp_path / "scene.toml").gait == OWN
    two = replace(GAIT, joint_gain=(1.0, 1.0))
    for make, said in (
        (lambda: sn.steady_gait(PAPER, VISCOUS, two), "has 2 values; the robot has 5 joints"),
        (lambda: replace(scene, gait=two), "has 2 values"),
        (lambda: replace(GAIT, joint_gain=(3.0,)), "joint_gain is 3"),
    ):
        with refused(said):
            make()
