"""Least-power gaits on dry ground against brute force over shapes and rates.

The truths are the least of 22 x 22 shapes by 26 rates, refined four times round the best four
shapes, of random robots, speeds and joint limits; these are those that a search by quadratic models
missed by most, or was in doubt of by up to three quarters of the power.
"""

from __future__ import annotations

import math

import pytest
import serpenoid as sn

# robot (links, kg, m), ground (ct, cn, ft0, fn0), speed, m/s, joint limit, deg; least power, W, of
# "abs_power" or another
MISSED = {
    "0.9 % dearer": (
        (5, 0.45943429246116513, 0.07051593721038911),
        (0.020871867742908463, 0.16789645225054473, 0.05715156942253425, 0.2942578329248041),
        (0.04034045259108376, 60.0, 0.0175772),
        "abs_power",
    ),
    "a claim of 76 %": (
        (9, 0.10426590242042143, 0.050339908865147553),
        (0.003278329202757812, 0.09802456577026714, 0.012965759024969435, 0.41094517809084335),
        (0.8133859078454813, 45.0, 0.12274),
        "abs_power",
    ),
    "fast, in a steep narrow valley": (
        (4, 0.4368873963333472, 0.06518234677436506),
        (0.00768149267040795, 0.162085693600377, 0.4276854053646652, 2.048345813694247),
        (0.992756747643218, 45.0, 40.3894),
        "positive_power",
    ),
    "dry friction alone": (
        (10, 0.2778224136759066, 0.09211346747300422),
        (0.0, 0.0, 0.2526157535449081, 0.5387583600931392),
        (0.4850894910007392, 90.0, 2.89068),
        "abs_power",
    ),
}


@pytest.mark.parametrize("case", MISSED.values(), ids=MISSED)
def test_brute_force_finds_nothing_cheaper_than_the_claim(case: tuple) -> None:
    robot, ground, (speed, limit_deg, least_w), cost = case
    best = sn.least_power_gait(
        sn.Robot(*robot),
        sn.Ground(*ground),
        speed_m_s=speed,
        cost=cost,
        limits=sn.GaitLimits(joint_angle_rad=math.radians(limit_deg)),
    )
    assert best.power_w <= least_w + best.power_error_w
    assert best.power_error_w < 0.01 * best.power_w
    assert best.speed_m_s == pytest.approx(speed, rel=1e-4)
