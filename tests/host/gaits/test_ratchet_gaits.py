"""Least power on ratchet wheels: waves either way."""

from __future__ import annotations

import pytest
import serpenoid as sn

ROBOT = sn.Robot(3, 0.0756, 0.076)


def test_a_robot_turned_round_takes_the_wave_turned_round() -> None:
    """The gait is the same, to the last bit of the search; and brute force finds none cheaper."""
    ground = sn.Ground((0.014, 0.14), 0.2)
    here = sn.least_power_gait(ROBOT, ground, speed_m_s=0.03)
    there = sn.least_power_gait(ROBOT, ground.turned_round(), speed_m_s=0.03)
    assert (there.gait.alpha_rad, -there.gait.beta_rad) == (here.gait.alpha_rad, here.gait.beta_rad)
    assert here.gait.beta_rad > 0
    assert there.steady.speed_m_s == pytest.approx(0.03, rel=1e-4)
    grid = sn.sweep(
        ROBOT,
        ground,
        alpha_rad=[0.6, 0.9, 1.2],
        beta_rad=[-1.8, -1.2, -0.6, 0.6, 1.2, 1.8],
        omega_rad_s=[2.0, 2.5, 3.0, 4.0, 5.0],
        rtol=1e-3,
    )
    reaches = grid.speed_m_s >= 0.03
    assert reaches.any()
    assert grid.power_w[reaches].min() > here.power_w - here.power_error_w
