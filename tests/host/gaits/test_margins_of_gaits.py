"""Margins of gaits: beside the cliff, below it, away from one."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
import serpenoid as sn
from robots import BINGHAM, OF_2005, PAPER, VISCOUS

D = math.pi / 180
FRAGILE, STURDY = sn.Gait(66.7 * D, 78.8 * D, 1.6), sn.Gait(80 * D, 75 * D, 1.75)


def test_the_gait_beside_the_cliff_is_told_from_the_one_that_survives() -> None:
    fragile = sn.gait_margins(OF_2005, BINGHAM, FRAGILE)
    sturdy = sn.gait_margins(OF_2005, BINGHAM, STURDY)
    assert fragile.near_cliff
    assert not sturdy.near_cliff
    assert fragile.amplitude_loss == pytest.approx(0.45, abs=0.03)
    assert fragile.grip_loss == pytest.approx(0.50, abs=0.03)
    assert fragile.amplitude < 0.06
    assert sturdy.amplitude > 0.2
    assert "10 % less amplitude costs 44 %" in fragile.warning
    assert sturdy.warning == ""


@pytest.mark.parametrize(
    ("robot", "ground", "gait"),
    [
        (PAPER, VISCOUS, sn.Gait(30 * D, 0.0, 5.0)),
        (PAPER, VISCOUS, sn.Gait(0.0, 80 * D, 5.0)),
        (PAPER, sn.Ground(1.0, 1.0), sn.Gait(30 * D, 80 * D, 5.0)),
        (sn.Robot(2, 0.1, 0.1), BINGHAM, sn.Gait(60 * D, 75 * D, 3.14)),
    ],
    ids=["standing wave", "no amplitude", "isotropic", "two links"],
)
def test_a_gait_that_does_not_travel_has_no_margins(robot, ground, gait) -> None:
    margins = sn.gait_margins(robot, ground, gait)
    assert not margins.travels
    assert not margins.near_cliff
    assert margins.warning == "this gait does not travel: there is no speed to lose"


def test_a_gait_below_the_cliff_is_told_what_it_misses() -> None:
    """At 40 deg the wheels hardly let go; a small viscous gait is slow, but no cliff is near."""
    stuck = sn.gait_margins(OF_2005, BINGHAM, sn.Gait(40 * D, 75 * D, 1.57))
    assert stuck.below_cliff
    more = sn.steady_gait(OF_2005, BINGHAM, sn.Gait(64 * D, 75 * D, 1.57), rtol=1e-3).speed_m_s
    now = sn.steady_gait(OF_2005, BINGHAM, sn.Gait(40 * D, 75 * D, 1.57), rtol=1e-3).speed_m_s
    assert stuck.far_gain == pytest.approx(more / now - 1, rel=0.01)
    assert "this gait is below a cliff" in stuck.warning
    tiny = sn.gait_margins(PAPER, VISCOUS, sn.Gait(2 * D, 80 * D, 5.0))
    assert not tiny.below_cliff
    assert math.isnan(tiny.grip)
    assert tiny.warning == ""


def test_the_mirror_and_the_reverse_of_a_gait_have_its_margins() -> None:
    one = sn.gait_margins(OF_2005, BINGHAM, STURDY)
    back = sn.gait_margins(OF_2005, BINGHAM, replace(STURDY, beta_rad=-STURDY.beta_rad))
    assert back.amplitude == pytest.approx(one.amplitude, rel=0.02)
    assert back.grip == pytest.approx(one.grip, rel=0.02)
    turning = sn.gait_margins(OF_2005, BINGHAM, replace(STURDY, offset_rad=5 * D))
    assert 0.05 < turning.amplitude < 0.6
