"""The implicit model's periodic state: published errors of the springs, limits, energy."""

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
def test_the_papers_springs_err_as_the_independent_reference_says(
    omega: float, percent: float
) -> None:
    soft = sn.steady_springs(PAPER, VISCOUS, gait(omega))
    assert 100 * soft.modelling_error == pytest.approx(percent, abs=0.05)
    assert soft.error_estimate < 1e-4


def test_bad_input_is_named() -> None:
    with refused("rtol is 0"):
        sn.steady_springs(PAPER, VISCOUS, gait(5.0), rtol=0)
    with refused(r"and joint_damping_n_s_m 1e\+06 ask for .* time steps a cycle"):
        sn.steady_springs(OF_2005, BINGHAM, gait(5.0), joint_damping_n_s_m=1e6)
    with refused("joint_stiffness_n_m is -1"):
        sn.steady_springs(PAPER, VISCOUS, gait(5.0), joint_stiffness_n_m=-1.0)


def random_robots() -> list[dict[str, float]]:
    table = Path(__file__).parents[2] / "oracle" / "periodic_springs.csv"
    with table.open(newline="") as file:
        found = [{k: float(v) for k, v in row.items()} for row in csv.DictReader(file)]
    assert len(found) == 8
    return found


@pytest.mark.parametrize("rtol", [1e-2, 1e-6])
def test_random_robots_are_as_near_to_shooting_as_they_claim(rtol: float) -> None:
    """From 2 to 12 links, springs of 30 to 10 000 m omega^2; the other code takes plain steps."""
    for v in random_robots():
        soft = sn.steady_springs(
            sn.Robot(int(v["links"]), v["mass_kg"], 2 * v["half_m"]),
            sn.Ground(v["ct"], v["cn"]),
            sn.Gait(v["alpha_rad"], v["beta_rad"], v["omega_rad_s"]),
            joint_stiffness_n_m=v["stiffness_n_m"],
            joint_damping_n_s_m=v["damping_n_s_m"],
            rtol=rtol,
        )
        size = 1e-4 * v["omega_rad_s"] * 2 * v["half_m"] * v["links"]
        off = abs(soft.speed_m_s - v["speed_m_s"]) / max(v["speed_m_s"], size)
        assert off <= soft.error_estimate + v["steps_error"] + 1e-9
        assert soft.error_estimate <= 2 * rtol
        watts = v["power_steps_error"] * v["abs_power_w"]
        assert abs(soft.power_w - v["power_w"]) <= soft.power_error_w + watts
        assert abs(soft.abs_power_w - v["abs_power_w"]) <= soft.abs_power_error_w + watts
        off_w = abs(soft.positive_power_w - v["positive_power_w"])
        assert off_w <= soft.positive_power_error_w + watts
