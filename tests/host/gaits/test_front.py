"""The front of least power over speeds: scaling, single calls, order, and what cannot be asked.

Power over speed squared is one number only where inertia does not count (creeping on viscous
ground); else a robot of half the mass at twice the speed does the same at four times the power.
"""

from __future__ import annotations

import math
from typing import Any

import pytest
import serpenoid as sn
from refusals import refused
from robots import BINGHAM, OF_2005, PAPER, VISCOUS
from serpenoid.gaits.limits import peak_torque_nm

SMALL, SPRINGS = sn.Robot(3, 0.4, 0.11), {"joint_stiffness_n_m": 60.0, "joint_damping_n_s_m": 4.0}
KINDS: dict[str, tuple[sn.Robot, sn.Ground, dict[str, Any]]] = {
    "viscous": (PAPER, VISCOUS, {}),
    "dry": (OF_2005, BINGHAM, {}),
    "springs": (SMALL, sn.Ground(0.06, 1.1), {"formulation": "implicit", **SPRINGS}),
}


def found(kind: str, speeds: list[float], **more: Any) -> list[sn.LeastPower]:
    robot, ground, given = KINDS[kind]
    front = sn.power_front(robot, ground, speeds_m_s=speeds, **given, **more)
    assert None not in front
    return [best for best in front if best is not None]


@pytest.mark.parametrize(
    "kind",
    [
        "viscous",
        "dry",
        pytest.param("springs", marks=pytest.mark.slow),
    ],
)
def test_each_point_is_what_a_single_call_finds(kind: str) -> None:
    first, second, third = found(kind, [0.06, 0.03, 0.06])
    assert first.power_w == third.power_w
    assert second.power_w < first.power_w
    assert [first.speed_m_s, second.speed_m_s] == pytest.approx([0.06, 0.03], rel=3e-4)
    robot, ground, given = KINDS[kind]
    one = sn.least_power_gait(robot, ground, speed_m_s=0.06, **given)
    assert one.formulation == first.formulation
    assert abs(one.power_w - first.power_w) <= one.power_error_w + first.power_error_w


def test_mass_and_speed_count_together() -> None:
    """Mass times rate over friction is all there is: half the mass, twice the speed."""
    speeds = [0.1, 0.4, 1.0]
    heavy = found("viscous", speeds)
    light = sn.power_front(
        sn.Robot(6, 0.5, 0.12), VISCOUS, speeds_m_s=[2 * speed for speed in speeds]
    )
    for one, other in zip(heavy, light, strict=True):
        assert other is not None
        assert other.power_w == pytest.approx(4 * one.power_w, rel=1e-6)
        assert other.gait.omega_rad_s == pytest.approx(2 * one.gait.omega_rad_s, rel=2e-3)


@pytest.mark.slow
def test_a_torque_limit_is_met_and_told() -> None:
    limits = sn.GaitLimits(servo_torque_nm=0.2)
    best = sn.least_power_gait(PAPER, VISCOUS, speed_m_s=0.39, limits=limits)
    assert best.active == ("servo torque",)
    assert peak_torque_nm(PAPER, VISCOUS, best.gait) <= 0.2 * 1.002


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
