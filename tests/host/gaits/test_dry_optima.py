"""Gaits of least power in cases that are difficult for a search, compared with brute force.

The expected powers are the least on a grid of 22 x 22 shapes and 26 rates, refined four times
around the best four shapes, or the result of the same search with a narrower limit.
"""

from __future__ import annotations

from typing import Any

import pytest
import serpenoid as sn
from robots import BINGHAM, OF_2005

FIVE_LINKS = sn.Robot(5, 0.27520463314816174, 0.11092339815470859)
LOW_FRICTION = sn.Ground(0.005672596582976471, 0.01222706077935121, 0.00475924833, 0.02106086158)
STEEP_VALLEY = {"speed_m_s": 0.10444748807, "cost": "abs_power"}
# Robot, ground, speed and kind of cost, limits, and the least known power, W.
KNOWN: dict[str, tuple[sn.Robot, sn.Ground, dict[str, Any], dict[str, float], float]] = {
    "a result 0.9 % too high": (
        sn.Robot(5, 0.45943429246116513, 0.07051593721038911),
        sn.Ground(
            0.020871867742908463, 0.16789645225054473, 0.05715156942253425, 0.2942578329248041
        ),
        {"speed_m_s": 0.04034045259108376, "cost": "abs_power"},
        {"joint_angle_rad": 1.047197551},
        0.0175772,
    ),
    "an error estimate of 76 %": (
        sn.Robot(9, 0.10426590242042143, 0.050339908865147553),
        sn.Ground(
            0.003278329202757812, 0.09802456577026714, 0.012965759024969435, 0.41094517809084335
        ),
        {"speed_m_s": 0.8133859078454813, "cost": "abs_power"},
        {"joint_angle_rad": 0.785398163},
        0.12274,
    ),
    "fast, in a steep narrow valley": (
        sn.Robot(4, 0.4368873963333472, 0.06518234677436506),
        sn.Ground(0.00768149267040795, 0.162085693600377, 0.4276854053646652, 2.048345813694247),
        {"speed_m_s": 0.992756747643218, "cost": "positive_power"},
        {"joint_angle_rad": 0.785398163},
        40.3894,
    ),
    "dry friction alone": (
        sn.Robot(10, 0.2778224136759066, 0.09211346747300422),
        sn.Ground(0.0, 0.0, 0.2526157535449081, 0.5387583600931392),
        {"speed_m_s": 0.4850894910007392, "cost": "abs_power"},
        {"joint_angle_rad": 1.570796327},
        2.89068,
    ),
    "the second best valley": (
        sn.Robot(4, 0.15264, 0.11232),
        sn.Ground(0.14155, 0.14155, 0.0048985, 0.086985),
        {"speed_m_s": 0.0121984, "cost": "positive_power"},
        {},
        4.586e-4,
    ),
    "the wider limit in a steep valley": (
        FIVE_LINKS,
        LOW_FRICTION,
        STEEP_VALLEY,
        {"joint_angle_rad": 0.554224853},
        1.523,
    ),
    "the lower of two minima": (
        sn.Robot(4, 0.37662905720816725, 0.08),
        sn.Ground(0.04056232763487284, 1.05366319869, 0.03368348702573, 0.0866812022647),
        {"speed_m_s": 0.02963641792874, "cost": "positive_power"},
        {},
        0.0097965,
    ),
    "a valley that bends beside a standing wave": (
        sn.Robot(3, 0.11338072864002047, 0.08),
        sn.Ground(0.018557509430704677, 0.33922841365944, 0.03524013860429, 0.25270662628),
        {"speed_m_s": 0.0326805509016225},
        {"joint_angle_rad": 0.5685552},
        0.004185,
    ),
    "a lowest rate far above the best": (
        OF_2005,
        BINGHAM,
        {"speed_m_s": 0.005},
        {"omega_low_rad_s": 8.0},
        0.0026,
    ),
    "two minima at a lowest rate": (
        sn.Robot(4, 0.3562561675850163, 0.07151951441431956),
        sn.Ground(0.26988988044344103, 1.3229162038107374, 0.06467369140, 0.1164993605634),
        {"speed_m_s": 0.14513107255, "cost": "abs_power"},
        {"omega_low_rad_s": 20.9408567215594},
        3.976,
    ),
}


SLOW = (
    "dry friction alone",
    "an error estimate of 76 %",
    "a result 0.9 % too high",
    "two minima at a lowest rate",
)


@pytest.mark.parametrize(
    "case",
    [
        pytest.param(case, id=name, marks=[pytest.mark.slow] if name in SLOW else [])
        for name, case in KNOWN.items()
    ],
)
def test_power_is_at_most_the_known_one(case: tuple) -> None:
    robot, ground, task, limit, known_w = case
    limits = sn.GaitLimits(**limit)
    best = sn.least_power_gait(robot, ground, limits=limits, **task)
    assert best.power_w <= known_w + best.power_error_w
    assert best.power_error_w < 0.01 * best.power_w
    assert best.speed_m_s == pytest.approx(task["speed_m_s"], rel=1e-4)
    assert min(limits.margins(best.gait).values()) > -2e-3
