"""Least-power gaits: the published ones, no neighbour cheaper, refusals."""

from __future__ import annotations

import math

import pytest
import serpenoid as sn

PAPER, VISCOUS = sn.Robot(6, 1.0, 0.12), sn.Ground(0.1, 10.0)
OF_2005 = sn.Robot(6, 0.0756, 0.076)
BINGHAM = sn.Ground.whole_body(6, 0.084, 1.2, 0.14, 0.27)


@pytest.mark.parametrize(
    ("speed", "omega", "alpha_deg", "beta_deg", "watts"),
    [(0.10, 1.7987, 31.77, 83.70, 7.63769e-3), (0.50, 10.138, 25.48, 86.66, 0.22733)],
)
def test_published_gaits(speed, omega, alpha_deg, beta_deg, watts) -> None:
    best = sn.least_power_gait(PAPER, VISCOUS, speed_m_s=speed)
    assert best.power_w == pytest.approx(watts, rel=2e-5)
    assert best.speed_m_s == pytest.approx(speed, rel=1e-8)
    # the valley is flat: the last digits of the gait are worth less than 1e-8 of the power
    assert best.gait.omega_rad_s == pytest.approx(omega, rel=1e-3)
    assert math.degrees(best.gait.alpha_rad) == pytest.approx(alpha_deg, abs=0.05)
    assert math.degrees(best.gait.beta_rad) == pytest.approx(beta_deg, abs=0.05)


@pytest.mark.parametrize("cost", ["power", "abs_power", "positive_power"])
def test_no_neighbour_at_the_same_speed_is_cheaper(cost: str) -> None:
    best = sn.least_power_gait(PAPER, VISCOUS, speed_m_s=0.2, cost=cost)
    for da, db in ((1, 0), (-1, 0), (0, 1), (0, -1)):
        alpha = best.gait.alpha_rad + math.radians(da)
        beta = best.gait.beta_rad + math.radians(db)
        low, high = 0.5 * best.gait.omega_rad_s, 2 * best.gait.omega_rad_s
        for _ in range(50):  # bisect the rate that gives the speed
            omega = 0.5 * (low + high)
            s = sn.steady_gait(PAPER, VISCOUS, sn.Gait(alpha, beta, omega), rtol=1e-8)
            low, high = (omega, high) if s.speed_m_s < 0.2 else (low, omega)
        assert getattr(s, f"{cost}_w") > best.power_w


def test_servos_that_do_not_regenerate_want_smaller_swings() -> None:
    """The study: alpha 14 to 22 deg, beta 42 to 69 deg under sum |P_i| and sum P_i^+."""
    for cost in ("abs_power", "positive_power"):
        gait = sn.least_power_gait(PAPER, VISCOUS, speed_m_s=0.2, cost=cost).gait
        assert 13 < math.degrees(gait.alpha_rad) < 23
        assert 41 < math.degrees(gait.beta_rad) < 70


def test_sticking_wheels() -> None:
    best = sn.least_power_gait(OF_2005, BINGHAM, speed_m_s=0.15)
    papers = sn.steady_gait(OF_2005, BINGHAM, sn.Gait(math.radians(70), math.radians(75), 6.0))
    assert best.speed_m_s == pytest.approx(0.15, rel=1e-3)
    assert best.power_w / best.speed_m_s < papers.power_w / papers.speed_m_s


def test_refusals() -> None:
    with pytest.raises(sn.BadInput, match="speed_m_s is 0"):
        sn.least_power_gait(PAPER, VISCOUS, speed_m_s=0.0)
    with pytest.raises(sn.BadInput, match="cost is 'heat'"):
        sn.least_power_gait(PAPER, VISCOUS, speed_m_s=0.1, cost="heat")
    isotropic = sn.Ground(1.0, 1.0)  # no wheel grips better than another: nothing travels
    with pytest.raises(sn.NotConverged, match="no gait of the search grid"):
        sn.least_power_gait(PAPER, isotropic, speed_m_s=0.1)
