"""Dry gaits that once did not converge, and how many of random ones do not."""

from __future__ import annotations

import math

import numpy as np
import pytest
import serpenoid as sn

OF_2005 = sn.Robot(6, 0.0756, 0.076)
BINGHAM = sn.Ground.whole_body(6, 0.084, 1.2, 0.14, 0.27)


@pytest.mark.parametrize(
    ("alpha", "beta", "omega"), [(20, 35, 6), (20, 50, 11), (20, 50, 13), (35, 80, 11)]
)
def test_a_tight_tolerance_where_the_speed_nearly_vanishes(
    alpha: float, beta: float, omega: float
) -> None:
    gait = sn.Gait(math.radians(alpha), math.radians(beta), float(omega))
    s = sn.steady_gait(OF_2005, BINGHAM, gait, rtol=1e-7)
    assert s.error_estimate < 1e-7
    assert s.speed_m_s == pytest.approx(
        sn.steady_gait(OF_2005, BINGHAM, gait, rtol=1e-6).speed_m_s, rel=3e-6
    )


def test_wild_dry_robots_converge() -> None:
    """Links 3 to 12, friction over decades: at most two in a hundred without an answer."""
    rng = np.random.default_rng(11)

    def between(low: float, high: float) -> float:
        return float(np.exp(rng.uniform(math.log(low), math.log(high))))

    lost = 0
    for _ in range(100):
        robot = sn.Robot(int(rng.integers(3, 13)), between(0.003, 3), between(0.02, 0.3))
        along, dry = between(1e-3, 3), robot.link_mass_kg * 9.81 * between(1e-3, 1)
        ground = sn.Ground(along, along * between(1e-2, 1e3), ft0=dry, fn0=dry * between(0.1, 30))
        gait = sn.Gait(rng.uniform(0.05, 1.5), rng.uniform(0.1, 1.7), between(0.1, 30))
        try:
            sn.steady_gait(robot, ground, gait)
        except sn.NotConverged:
            lost += 1
    assert lost <= 2
