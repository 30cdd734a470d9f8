"""Random robots of 2 to 99 links on random ground, against integrations by other code."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
import serpenoid as sn

TABLE = Path(__file__).parents[2] / "oracle" / "periodic_random.csv"


def rows() -> list[dict[str, float]]:
    with TABLE.open(newline="") as file:
        found = [{k: float(v) for k, v in row.items()} for row in csv.DictReader(file)]
    assert len(found) > 30
    return found


def solved(v: dict[str, float], rtol: float) -> sn.Steady:
    robot = sn.Robot(int(v["links"]), v["mass_kg"], 2 * v["half_length_m"])
    ground = sn.Ground((v["ct"], v["ct_back"]), v["cn"], (v["ft0"], v["ft0_back"]), v["fn0"])
    gait = sn.Gait(v["alpha_rad"], v["beta_rad"], v["omega_rad_s"], v["offset_rad"])
    return sn.steady_gait(robot, ground, gait, rtol=rtol)


@pytest.mark.parametrize("rtol", [1e-3, 1e-6])
def test_errors_are_within_their_claims(rtol: float) -> None:
    """None off by four times its claim, at most one in ten by more than it: three, and one 3.5."""
    over = []
    for v in rows():
        s = solved(v, rtol)
        size = s.gait.omega_rad_s * s.robot.body_length_m
        # the table's own: its shortest steps (order one), and what its quadrature of powers misses
        missed = (3 * v["work_missed"] + 3e-7) * v["positive_power_w"]
        ratios = [
            (abs(s.speed_m_s - v["speed_m_s"]) - 1e-8 * size)
            / (s.error_estimate * max(v["speed_m_s"], 1e-4 * size)),
            (abs(s.power_w - v["power_w"]) - 1e-7 * v["power_w"]) / s.power_error_w,
            (abs(s.positive_power_w - v["positive_power_w"]) - missed) / s.positive_power_error_w,
        ]
        over.append(max(ratios))
        assert s.turn_rad_per_cycle == pytest.approx(v["turn_rad_per_cycle"], abs=rtol, rel=rtol)
        assert s.error_estimate <= max(rtol, rtol * 1e-4 * size / max(v["speed_m_s"], 1e-300))
    assert max(over) < 4  # of P+ where three wheels stick: 0.4 % where 1 % is asked
    assert np.mean(np.array(over) > 1) <= 0.1


def test_the_state_is_the_one_that_comes_back() -> None:
    for v in rows():
        s = solved(v, 1e-6)
        scale = s.gait.omega_rad_s * s.robot.link_length_m / 2 * s.gait.alpha_rad
        start = np.array([v["u0_x_m_s"], v["u0_y_m_s"], v["u0_spin_rad_s"]])
        gap = (s.body_velocity - start) / scale
        gap[2] *= s.robot.body_length_m
        assert np.abs(gap).max() < 1e-4
