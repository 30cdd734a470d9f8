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


def test_a_wider_joint_limit_of_slow_dry_gaits_costs_no_more() -> None:
    robot, ground = sn.Robot(6, 0.0756, 0.076), sn.Ground.whole_body(6, 0.084, 1.2, 0.14, 0.27)
    limits = [sn.GaitLimits(joint_angle_rad=math.radians(deg)) for deg in (45, 50, 110)]
    found = [sn.least_power_gait(robot, ground, speed_m_s=0.005, limits=one) for one in limits]
    for narrow, wide in pairwise(found):
        assert wide.power_w <= narrow.power_w + wide.power_error_w


@pytest.mark.parametrize(
    "seed", [0, 3, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (1, 2, *range(4, 24)))]
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
