"""The implicit model's periodic state: published errors of the springs, limits, energy."""

from __future__ import annotations

import math

import pytest
import serpenoid as sn

SIX, VISCOUS = sn.Robot(6, 1.0, 0.12), sn.Ground(0.1, 10.0)


def gait(omega_rad_s: float) -> sn.Gait:
    return sn.Gait(math.radians(30), math.radians(80), omega_rad_s)


@pytest.mark.parametrize(("omega", "percent"), [(5.0, 1.94), (10.0, 8.04), (20.0, 42.2)])
def test_the_papers_springs_err_as_the_independent_reference_says(
    omega: float, percent: float
) -> None:
    soft = sn.steady_springs(SIX, VISCOUS, gait(omega))
    assert 100 * soft.modelling_error == pytest.approx(percent, abs=0.05)
    assert soft.error_estimate < 1e-4


def test_stiff_springs_give_the_exact_model() -> None:
    exact = sn.steady_gait(SIX, VISCOUS, gait(5.0))
    soft = sn.steady_springs(SIX, VISCOUS, gait(5.0), joint_stiffness_n_m=1e6, rtol=1e-6)
    assert abs(soft.modelling_error) == pytest.approx(1.94e-2 / 1e3, rel=0.1)  # falls as 1/k
    assert soft.abs_power_w == pytest.approx(exact.abs_power_w, rel=2e-3)
    assert soft.positive_power_w == pytest.approx(exact.positive_power_w, rel=2e-3)


def test_dry_ground_too() -> None:
    robot, ground = sn.Robot(6, 0.0756, 0.076), sn.Ground.whole_body(6, 0.084, 1.2, 0.14, 0.27)
    fast = sn.Gait(math.radians(70), math.radians(75), 5.0)
    soft = sn.steady_springs(robot, ground, fast, joint_stiffness_n_m=1e4)
    assert soft.speed_m_s == pytest.approx(0.133205, rel=3e-3)


def test_bad_input_is_named() -> None:
    with pytest.raises(sn.BadInput, match="rtol is 0"):
        sn.steady_springs(SIX, VISCOUS, gait(5.0), rtol=0)
    with pytest.raises(sn.BadInput, match="joint_stiffness_n_m is -1"):
        sn.steady_springs(SIX, VISCOUS, gait(5.0), joint_stiffness_n_m=-1.0)
