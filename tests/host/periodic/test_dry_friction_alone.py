"""Ground with dry friction alone: fast gaits there coast, and hardly feel the friction at all."""

from __future__ import annotations

import math

import pytest
import serpenoid as sn

WEIGHT_N = 9.81 * 0.0756
# links, ft0 and fn0 over a link's weight, alpha, beta, omega. Of each the friction is the same
# over a wide stretch of speeds, so that Newton's steps were thousands of speed scales long.
COASTING = [
    (6, 0.1, 0.5, 0.4536949563820278, 1.361050007300421, 2.407649710800713),
    (6, 0.3, 0.3, 1.113037876228759, 2.740808632354806, 243.51310254541636),
    (12, 0.1, 0.5, 0.23717366932496314, 0.8847682360421236, 77.99323384726864),
    (12, 0.1, 0.5, 0.1764987578294038, 0.576736190695558, 336.74433043146234),
    (24, 0.1, 0.5, math.radians(50), math.radians(40), 6.0),
]


def parts(case: tuple) -> tuple[sn.Robot, sn.Ground, sn.Gait]:
    links, along, across, *gait = case
    ground = sn.Ground(0.0, 0.0, ft0=along * WEIGHT_N, fn0=across * WEIGHT_N)
    return sn.Robot(links, 0.0756, 0.076), ground, sn.Gait(*gait)


@pytest.mark.parametrize("case", COASTING, ids=lambda c: f"{c[0]}-{c[-1]:.4g}")
def test_a_run_in_time_stays_in_the_state(case: tuple) -> None:
    robot, ground, gait = parts(case)
    s = sn.steady_gait(robot, ground, gait, rtol=1e-5, powers=False)
    scene = sn.Scene(
        robot,
        ground,
        gait,
        start="steady",
        method="nonsmooth",
        tolerance=1e-9,
        record_every=1,
        dt_s=gait.period_s,
        duration_s=gait.period_s,
    )
    run = sn.simulate(scene)
    way = math.hypot(*(run.centre_m[-1] - run.centre_m[0]))
    assert way / gait.period_s == pytest.approx(s.speed_m_s, rel=3e-5)


def test_a_state_that_is_reached_exactly() -> None:
    """All wheels stuck for a while leave no trace of the start: the residual is zero, not small."""
    robot = sn.Robot(10, 0.0357522196679968, 0.08091914625803796)
    ground = sn.Ground(
        0.0027662903510797003, 0.04813983618393585, 0.022137581097646956, 0.12490357249115072
    )
    gait = sn.Gait(0.29170170623666375, 0.6119331579759424, 3.8533606035499983)
    assert sn.steady_gait(robot, ground, gait, rtol=3e-4).speed_m_s == pytest.approx(0.460338, 1e-5)
