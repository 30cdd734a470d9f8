"""Optima stand in order: wider limits never cost more, nor does a power that counts less."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
import serpenoid as sn

COSTS = ("power", "positive_power", "abs_power")


@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.slow)])
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
