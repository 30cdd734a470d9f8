"""The cloud of gaits below its lowest rate: what it fills in is what the model gives there."""

from __future__ import annotations

import numpy as np
import pytest
import serpenoid as sn
from serpenoid.gaits.gait_cloud import GaitCloud
from serpenoid.gaits.limits import GaitLimits


def test_slower_than_the_lowest_rate_speed_goes_with_rate_and_power_with_its_square() -> None:
    """Heavily damped: inertia counts for nothing, and the motion is one of phase alone."""
    robot, ground = sn.Robot(6, 0.01, 0.076), sn.Ground(0.1, 10.0)
    cloud = GaitCloud(robot, ground, "power", GaitLimits(), [0.05])
    wanted = 0.3 * float(np.nanmin(cloud.speed_m_s[cloud.speed_m_s > 0]))
    rate, watts = cloud.at_speed(wanted)
    picked = np.argwhere(np.isfinite(watts))[::15]
    assert len(picked) > 3
    for i, j in picked:
        gait = sn.Gait(float(cloud.alpha_rad[i, j]), float(cloud.beta_rad[i, j]), float(rate[i, j]))
        s = sn.steady_gait(robot, ground, gait)
        assert s.speed_m_s == pytest.approx(wanted, rel=0.01)
        assert s.power_w == pytest.approx(watts[i, j], rel=0.02)
