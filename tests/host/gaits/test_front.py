"""The front of least power over speeds: scaling, limits, and what cannot be asked.

Power over speed squared is one number only where inertia does not count (creeping on viscous
ground); else a robot of half the mass at twice the speed does the same at four times the power.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import pytest
import serpenoid as sn
from refusals import refused
from robots import PAPER, VISCOUS


def test_mass_and_speed_count_together() -> None:
    """Mass times rate over friction is all there is: half the mass, twice the speed."""
    speeds = [0.1, 0.4, 1.0]
    heavy = sn.power_front(PAPER, VISCOUS, speeds_m_s=speeds)
    light = sn.power_front(
        sn.Robot(6, 0.5, 0.12), VISCOUS, speeds_m_s=[2 * speed for speed in speeds]
    )
    for one, other in zip(heavy, light, strict=True):
        assert one is not None
        assert other is not None
        assert other.power_w == pytest.approx(4 * one.power_w, rel=1e-6)
        assert other.gait.omega_rad_s == pytest.approx(2 * one.gait.omega_rad_s, rel=2e-3)


@pytest.mark.slow
def test_a_torque_limit_is_met_and_told() -> None:
    limits = sn.GaitLimits(servo_torque_nm=0.2)
    best = sn.least_power_gait(PAPER, VISCOUS, speed_m_s=0.39, limits=limits)
    assert best.active == ("servo torque",)
    scene = sn.Scene(PAPER, VISCOUS, best.gait, start="steady", record=("joints",))
    run = sn.simulate(replace(scene, duration_s=best.gait.period_s))
    assert abs(run.joint_torque_nm).max() <= 0.2 * 1.002


def test_a_speed_out_of_reach_is_none_whatever_stands_beside_it() -> None:
    limits = sn.GaitLimits(omega_high_rad_s=6.0)
    front = sn.power_front(PAPER, VISCOUS, speeds_m_s=[3.0, 0.2], limits=limits)
    assert front[0] is None
    assert front[1] is not None
    assert front[1].power_w == pytest.approx(
        sn.least_power_gait(PAPER, VISCOUS, speed_m_s=0.2, limits=limits).power_w, rel=1e-6
    )


@pytest.mark.parametrize(
    ("speeds", "told"),
    [
        ([], "at least one speed"),
        (0.1, "at least one speed"),
        ([0.1, 0.0], "speed_m_s is 0.0"),
        ([0.1, math.nan], "speed_m_s is nan"),
        (["fast"], "speed_m_s is 'fast'"),
        ([True], "speed_m_s is True"),
    ],
)
def test_refusals(speeds: Any, told: str) -> None:
    with refused(told):
        sn.power_front(PAPER, VISCOUS, speeds_m_s=speeds)
