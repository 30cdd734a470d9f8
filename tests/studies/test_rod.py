"""PyElastica's rod crawls as fast as the exact model with the rod's inertia."""

from __future__ import annotations

import pytest
import rod
import serpenoid as sn
from robots import gait_in_deg


def test_the_rods_inertia_is_that_of_masses_at_the_joints() -> None:
    seen = rod.as_rod_sees_it(sn.Robot(6, 2.0, 0.12))
    assert seen.inertia_kg_m2 == pytest.approx(2.0 * 0.06**2 + 2.0 * 0.02**2 / 4)


@pytest.mark.slow
def test_a_rod_crawls_as_fast_as_the_exact_model_with_its_inertia() -> None:
    pytest.importorskip("elastica", reason="an optional peer: pip install 'serpenoid[bench]'")
    gait = gait_in_deg(30, 80, 5.0)
    exact = sn.steady_gait(rod.as_rod_sees_it(rod.ROBOT), rod.GROUND, gait).speed_m_s
    found = rod.follow(rod.ROBOT, rod.GROUND, gait)
    assert found.speed_m_s == pytest.approx(exact, rel=1e-2)
    assert found.bend_error_rad < 0.02
