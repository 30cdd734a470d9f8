"""Limits and errors that a gait states, from their definitions."""

from __future__ import annotations

import math

import pytest
import serpenoid as sn
from robots import OF_2005, PAPER, VISCOUS


def test_an_offset_takes_its_share_of_the_joint_angle() -> None:
    limits = sn.GaitLimits(joint_angle_rad=1.0)
    left = limits.margins(sn.Gait(0.6, 1.2, 3.0, -0.3))["joint_angle_rad"]
    assert left == pytest.approx(math.log(1.0 / 0.9))


def test_a_limit_counts_as_reached_from_a_thousandth_below_it_on() -> None:
    limits = sn.GaitLimits(joint_angle_rad=1.0, servo_speed_rad_s=5.0)
    assert limits.active(sn.Gait(0.999, 1.2, 5.0)) == ("joint angle", "servo speed")
    assert limits.active(sn.Gait(0.999, 1.2, 4.0)) == ("joint angle",)
    assert limits.active(sn.Gait(0.9, 1.2, 4.0)) == ()


def test_the_error_of_the_speed_is_part_of_the_powers() -> None:
    best = sn.least_power_gait(PAPER, VISCOUS, speed_m_s=0.1, cost="positive_power", rtol=1e-3)
    steady = best.steady
    assert best.solved_error_w >= 2 * steady.error_estimate * best.power_w
    assert best.solved_error_w >= steady.positive_power_error_w


def test_a_ratchet_names_the_cheaper_of_both_waves_as_best_and_the_other_as_runner_up() -> None:
    robot = OF_2005
    ground = sn.Ground((0.014, 0.05), 0.2)
    best = sn.least_power_gait(robot, ground, speed_m_s=0.05)
    other = sn.least_power_gait(robot, ground.turned_round(), speed_m_s=0.05)
    assert best.power_w <= best.runner_up_w < math.inf
    assert best.power_w == pytest.approx(other.power_w, rel=1e-3)
    assert best.runner_up_w == pytest.approx(other.runner_up_w, rel=0.02)
