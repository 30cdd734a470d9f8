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


@pytest.mark.slow
def test_a_robust_gait_of_a_robot_turned_round_is_turned_round() -> None:
    """The wave may run either way: what the good way costs, the robot turned round pays too."""
    ground = sn.Ground((0.014, 0.14), 0.2)
    doubt = sn.Uncertainty(friction=(0.2, 0.3, 0, 0), amplitude=0, common_amplitude=0, lag_rad=0)

    def found(on: sn.Ground) -> sn.RobustGait:
        return sn.robust_gait(ROBOT, on, speed_m_s=0.03, uncertainty=doubt, samples=32)

    here, there = found(ground), found(ground.turned_round())
    assert here.gait.beta_rad > 0
    assert there.gait.beta_rad == -here.gait.beta_rad
    assert there.power_w == pytest.approx(here.power_w, rel=3e-4)
    assert there.low_speed_m_s == pytest.approx(here.low_speed_m_s, rel=1e-3)
    assert there.low_speed_m_s >= 0.999 * 0.027
    assert there.checked_low_m_s == pytest.approx(here.checked_low_m_s, rel=1e-3)


def test_a_sample_turned_round_runs_the_wave_the_other_way() -> None:
    gait = sn.Gait(1.0, 1.8, 3.0)
    sample = sn.Uncertainty().samples(ROBOT, sn.Ground((0.014, 0.05), 0.2), 1)[0]
    turned = sample.turned_round()
    one = sn.steady_gait(ROBOT, sample.ground, sample.gait(gait), rtol=1e-6)
    back = sn.Gait(1.0, -1.8, 3.0)
    other = sn.steady_gait(ROBOT, turned.ground, turned.gait(back), rtol=1e-6)
    assert other.speed_m_s == pytest.approx(one.speed_m_s, rel=1e-5)
