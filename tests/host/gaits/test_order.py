"""Optima stand in order: wider limits never cost more, nor does a power that counts less."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
import serpenoid as sn

COSTS = ("power", "positive_power", "abs_power")
SLIDING = sn.Ground(0.005672596582976471, 0.01222706077935121, 0.00475924833, 0.02106086158)
FIVE = sn.Robot(5, 0.27520463314816174, 0.11092339815470859)


def watts(robot: sn.Robot, ground: sn.Ground, speed: float, cost: str, **limits: float) -> float:
    """Return the least power, W."""
    found = sn.least_power_gait(
        robot, ground, speed_m_s=speed, cost=cost, limits=sn.GaitLimits(**limits)
    )
    return found.power_w


def test_a_wider_joint_limit_in_a_steep_valley_costs_less() -> None:
    """2.904 W was answered where the narrower limit allows 2.498 W, and the wider 1.519 W."""
    narrow, wide = (
        watts(FIVE, SLIDING, 0.10444748807, "abs_power", joint_angle_rad=limit)
        for limit in (math.radians(31), 0.554224858041111)
    )
    assert narrow < 2.51
    assert wide < 1.523


def test_the_lower_of_two_low_places_in_a_flat_valley() -> None:
    """0.009813 W was answered at 80.6 deg and 71 deg, though both limits here allow 0.009795 W."""
    robot = sn.Robot(4, 0.37662905720816725, 0.08)
    ground = sn.Ground(0.04056232763487284, 1.05366319869, 0.03368348702573, 0.0866812022647)
    assert watts(robot, ground, 0.02963641792874, "positive_power") < 0.0097965


def test_a_valley_that_bends_beside_a_standing_wave() -> None:
    """0.004220 W was answered at the largest lag, 175 deg; a narrower limit allowed 0.004202 W."""
    robot = sn.Robot(3, 0.11338072864002047, 0.08)
    ground = sn.Ground(0.018557509430704677, 0.33922841365944, 0.03524013860429, 0.25270662628)
    found = watts(robot, ground, 0.0326805509016225, "power", joint_angle_rad=0.5685552)
    assert found < 0.004185


@pytest.mark.parametrize(
    "seed", [0, *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(1, 24))]
)
def test_random_ladders_of_limits_and_costs(seed: int) -> None:
    rng = np.random.default_rng((34, seed))
    robot = sn.Robot(int(rng.integers(3, 8)), float(rng.uniform(0.05, 0.5)), 0.08)
    ct = float(np.exp(rng.uniform(math.log(0.01), math.log(0.3))))
    dry = float(rng.uniform(0.01, 0.05)) * (seed % 2)
    ground = sn.Ground(ct, ct * float(rng.uniform(3, 60)), dry, dry * float(rng.uniform(2, 9)))
    speed = robot.body_length_m * float(rng.uniform(0.05, 0.3))
    best = [sn.least_power_gait(robot, ground, speed_m_s=speed, cost=cost) for cost in COSTS]
    for less, more in pairwise(best):
        assert less.power_w - less.power_error_w <= more.power_w
    free = best[0]
    before = math.inf
    for part in (0.85, 0.95, 1.05):
        limits = sn.GaitLimits(joint_angle_rad=part * free.gait.alpha_rad)
        one = sn.least_power_gait(robot, ground, speed_m_s=speed, limits=limits)
        assert one.power_w - one.power_error_w <= before
        before = one.power_w
    assert free.power_w - free.power_error_w <= before
