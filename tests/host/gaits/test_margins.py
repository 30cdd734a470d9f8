"""Margins of random robots' gaits beside runs in time with less amplitude and less grip."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import serpenoid as sn
from gaits.robots import between, run_speed


def random_gait(seed: int) -> tuple[sn.Robot, sn.Ground, sn.Gait]:
    """Return a robot on dry ground with its least-power gait, or one a tenth above it."""
    rng = np.random.default_rng((99, seed))
    robot = sn.Robot(
        int(rng.integers(3, 9)), between(rng, 0.03, 0.5), float(rng.uniform(0.04, 0.12))
    )
    fn0 = robot.link_mass_kg * 9.81 * between(rng, 0.03, 0.15)
    ct, cn = between(rng, 0.003, 0.05), between(rng, 0.05, 0.5)
    ground = sn.Ground(ct, cn, fn0 * rng.uniform(0.1, 0.6), fn0)
    speed = robot.links * robot.link_length_m * between(rng, 0.05, 0.3)
    gait = sn.least_power_gait(robot, ground, speed_m_s=speed).gait
    if seed % 2 == 0:
        gait = replace(gait, alpha_rad=min(1.1 * gait.alpha_rad, 3.0))
    return robot, ground, gait


def assert_margins_are_true(seed: int) -> sn.Margins:
    robot, ground, gait = random_gait(seed)
    margins = sn.gait_margins(robot, ground, gait)
    full = run_speed(robot, ground, gait, cycles=12)

    def left(amplitude: float, grip: float) -> float:
        weak = replace(gait, alpha_rad=(1 - amplitude) * gait.alpha_rad)
        return run_speed(robot, replace(ground, fn0=(1 - grip) * ground.fn0), weak, 12) / full

    for margin, axis in ((margins.amplitude, (1, 0)), (margins.grip, (0, 1))):
        if math.isinf(margin):
            assert left(0.6 * axis[0], 0.6 * axis[1]) > 0.9
            continue
        within, beyond = 0.97 * margin, 1.03 * margin
        assert left(within * axis[0], within * axis[1]) > 0.898
        assert left(beyond * axis[0], beyond * axis[1]) < 0.902
    assert 1 - left(0.1, 0.0) == pytest.approx(margins.amplitude_loss, abs=0.01)
    assert 1 - left(0.0, 0.13) == pytest.approx(margins.grip_loss, abs=0.01)
    return margins


def test_margins_at_a_cliff_and_away_from_one_are_true() -> None:
    assert assert_margins_are_true(3).near_cliff
    assert not assert_margins_are_true(10).near_cliff
