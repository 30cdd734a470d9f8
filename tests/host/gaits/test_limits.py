"""Limits and errors that a gait states, from their definitions."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
import serpenoid as sn
from gaits.robots import run_speed
from robots import BINGHAM, OF_2005, PAPER, VISCOUS


def test_an_offset_takes_its_share_of_the_joint_angle() -> None:
    limits = sn.GaitLimits(joint_angle_rad=1.0)
    left = limits.margins(sn.Gait(0.6, 1.2, 3.0, -0.3))["joint_angle_rad"]
    assert left == pytest.approx(math.log(1.0 / 0.9))


def test_the_error_of_the_speed_is_part_of_the_powers() -> None:
    best = sn.least_power_gait(PAPER, VISCOUS, speed_m_s=0.1, cost="positive_power", rtol=1e-3)
    steady = best.steady
    assert best.solved_error_w >= 2 * steady.error_estimate * best.power_w
    assert best.solved_error_w >= steady.positive_power_error_w


def test_losses_are_those_of_runs_in_time() -> None:
    """The gait beside a sharp drop of speed, and one that stays clear of it."""
    for angles_deg, loses in ((66.7, 78.8), True), ((80.0, 75.0), False):
        gait = sn.Gait.degrees(*angles_deg, hertz=0.26)
        losses = sn.speed_losses(OF_2005, BINGHAM, gait)
        full = run_speed(OF_2005, BINGHAM, gait)
        weak = replace(gait, alpha_rad=0.9 * gait.alpha_rad)
        slippery = replace(BINGHAM, cn=0.8 * BINGHAM.cn, fn0=0.8 * BINGHAM.fn0)
        left = run_speed(OF_2005, BINGHAM, weak), run_speed(OF_2005, slippery, gait)
        assert 1 - left[0] / full == pytest.approx(losses.amplitude, abs=0.02)
        assert 1 - left[1] / full == pytest.approx(losses.friction, abs=0.02)
        assert bool(losses.warning) is loses


@pytest.mark.parametrize(
    ("robot", "ground", "gait"),
    [
        (PAPER, VISCOUS, sn.Gait.degrees(30, 0, hertz=1)),
        (PAPER, sn.Ground(1.0, 1.0), sn.Gait.degrees(30, 80, hertz=1)),
        (sn.Robot(2, 0.1, 0.1), BINGHAM, sn.Gait.degrees(60, 75, hertz=0.5)),
    ],
    ids=["standing wave", "isotropic", "two links"],
)
def test_a_gait_that_does_not_travel_loses_nothing(robot, ground, gait) -> None:
    losses = sn.speed_losses(robot, ground, gait)
    assert losses.warning == "this gait does not travel: there is no speed to lose"
    assert losses.rows() == []


def test_a_gait_that_is_to_keep_its_speed_does_and_costs_more() -> None:
    free = sn.least_power_gait(OF_2005, BINGHAM, speed_m_s=0.05)
    limits = sn.GaitLimits(kept_speed_share=0.8)
    kept = sn.least_power_gait(OF_2005, BINGHAM, speed_m_s=0.05, limits=limits)
    assert free.losses.worst > 0.5
    assert sn.speed_losses(OF_2005, BINGHAM, kept.gait).worst == pytest.approx(0.2, abs=2e-3)
    assert free.power_w < kept.power_w < 1.2 * free.power_w
    assert kept.active == ("speed kept",)


def test_where_no_gait_keeps_the_share_one_that_loses_least_is_the_answer() -> None:
    limits = sn.GaitLimits(kept_speed_share=0.99)
    best = sn.least_power_gait(OF_2005, BINGHAM, speed_m_s=0.05, limits=limits)
    for alpha, beta in ((70, 75), (80, 70), (85, 60), (100, 75), (60, 50)):
        other = sn.Gait.degrees(alpha, beta, hertz=0.3)
        assert best.losses.worst < sn.speed_losses(OF_2005, BINGHAM, other).worst + 0.01
