"""The lab's belt, its instruments and its crawl: each against a formula."""

from __future__ import annotations

import math

import numpy as np
import pytest
import serpenoid as sn
from robots import OF_2005
from serpenoid.lab.belt import HALF_LENGTH_M, HALF_WIDTH_M, SLEW_M_S2, Belt
from serpenoid.lab.crawl import crawl_speed
from serpenoid.lab.instruments import Instrument
from serpenoid.lab.robot import LabRobot

VISCOUS = LabRobot(OF_2005, (sn.Ground(0.02, 0.5),))


def test_an_instrument_scales_the_true_value_and_then_adds_its_zero() -> None:
    rng = np.random.default_rng(1)
    assert Instrument(zero=0.1, scale=2.0).shows(3.0, rng) == pytest.approx(6.1)
    assert Instrument(zero=0.2, step=0.25).shows(0.5, rng) == pytest.approx(0.75)
    many = [Instrument(scatter=0.3).shows(1.0, rng) for _ in range(4000)]
    assert np.mean(many) == pytest.approx(1.0, abs=0.02)
    assert np.std(many) == pytest.approx(0.3, rel=0.05)


def test_a_belt_comes_to_speed_at_its_own_haste() -> None:
    belt = Belt(VISCOUS)
    belt.put()
    belt.run(0.1)
    belt.wait(0.2)
    assert belt.speed_m_s == pytest.approx(0.2 * SLEW_M_S2)
    belt.wait(1.8)
    assert belt.speed_m_s == pytest.approx(0.1)


def test_a_robot_is_off_the_belt_beyond_either_edge() -> None:
    belt = Belt(VISCOUS)
    for across in (0.99 * HALF_WIDTH_M, -0.99 * HALF_WIDTH_M):
        belt.put(across_m=across)
        assert not belt.lost
        belt.put(across_m=1.01 * across / 0.99)
        assert belt.lost
    belt.put()
    belt.run(0.5)
    belt.wait(6.0)  # nobody holds it: the belt takes it along
    assert belt.look().along_m < -HALF_LENGTH_M
    assert belt.lost


def test_a_crawl_is_measured_once_the_start_is_forgotten() -> None:
    """A fast gait on slippery wheels: three cycles are too few to forget the start."""
    gait = sn.Gait(0.6, 1.3, 4 * math.pi)
    steady = sn.steady_gait(OF_2005, sn.Ground(0.02, 0.5), gait)
    assert steady.settling_time_s > 1.5 * gait.period_s
    assert crawl_speed(VISCOUS, gait) == pytest.approx(steady.speed_m_s, rel=0.02)
