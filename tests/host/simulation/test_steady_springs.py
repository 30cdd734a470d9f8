"""Periodic states of the implicit model: error by the springs, refusals, independent references."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest
import serpenoid as sn
from refusals import refused
from robots import BINGHAM, OF_2005, PAPER, VISCOUS, gait_in_deg


def gait(omega_rad_s: float) -> sn.Gait:
    return gait_in_deg(30, 80, omega_rad_s)


@pytest.mark.parametrize(("omega", "percent"), [(5.0, 1.94), (10.0, 8.04), (20.0, 42.2)])
def test_the_error_by_the_papers_springs_equals_the_reference(omega: float, percent: float) -> None:
    soft = sn.steady_springs(PAPER, VISCOUS, gait(omega))
    assert 100 * soft.modelling_error == pytest.approx(percent, abs=0.05)
    assert soft.error_estimate < 1e-4


def test_bad_input_is_refused() -> None:
    with refused("rtol is 0"):
        sn.steady_springs(PAPER, VISCOUS, gait(5.0), rtol=0)
    with refused(r"and joint_damping_n_s_m 1e\+06 ask for .* time steps a cycle"):
        sn.steady_springs(OF_2005, BINGHAM, gait(5.0), joint_damping_n_s_m=1e6)
    with refused("joint_stiffness_n_m is -1"):
        sn.steady_springs(PAPER, VISCOUS, gait(5.0), joint_stiffness_n_m=-1.0)


def random_robots() -> list[dict[str, float]]:
    table = Path(__file__).parents[2] / "oracle" / "periodic_springs.csv"
    with table.open(newline="") as file:
        robots = [{k: float(v) for k, v in row.items()} for row in csv.DictReader(file)]
    assert len(robots) == 8
    return robots


@pytest.mark.parametrize("rtol", [1e-2, 1e-6])
def test_random_robots_agree_with_shooting_within_the_error_estimate(rtol: float) -> None:
    """2 to 12 links, springs of 30 to 10 000 m omega^2; the reference uses fixed steps."""
    for values in random_robots():
        soft = sn.steady_springs(
            sn.Robot(int(values["links"]), values["mass_kg"], 2 * values["half_m"]),
            sn.Ground(values["ct"], values["cn"]),
            sn.Gait(values["alpha_rad"], values["beta_rad"], values["omega_rad_s"]),
            joint_stiffness_n_m=values["stiffness_n_m"],
            joint_damping_n_s_m=values["damping_n_s_m"],
            rtol=rtol,
        )
        min_speed = 1e-4 * values["omega_rad_s"] * 2 * values["half_m"] * values["links"]
        error = abs(soft.speed_m_s - values["speed_m_s"]) / max(values["speed_m_s"], min_speed)
        assert error <= soft.error_estimate + values["steps_error"] + 1e-9
        assert soft.error_estimate <= 2 * rtol
        watts = values["power_steps_error"] * values["abs_power_w"]
        assert abs(soft.power_w - values["power_w"]) <= soft.power_error_w + watts
        assert abs(soft.abs_power_w - values["abs_power_w"]) <= soft.abs_power_error_w + watts
        error_w = abs(soft.positive_power_w - values["positive_power_w"])
        assert error_w <= soft.positive_power_error_w + watts
