"""A gait may have two stable motions: which one a start from rest reaches, and the other."""

from __future__ import annotations

import pytest
import serpenoid as sn
from robots import OF_2005

GAINS = (0.9336745413116935, 0.9060444751704962, 0.9791539102821627, 0.890030452956113)
SHIFTS = (-0.1312988896871905, -0.06338689422875218, 0.17445656634035472, -0.02645669039453824)


def test_a_gait_that_goes_straight_or_in_a_circle_says_so() -> None:
    """By an independent run in time the circle turns -.1974 rad, 11.3 degrees, a cycle."""
    state = sn.steady_gait(
        sn.Robot(5, 0.8897103695729025, 0.28510368385558316),
        sn.Ground(
            0.0006115766747115468, 0.007260020669181927, 0.007326248646415052, 0.48860798522351667
        ),
        sn.Gait(1.1432119800600966, 0.70080509117233, 1.475344705493894, 0.0, GAINS, SHIFTS),
        from_rest=True,
    )
    assert state.turn_rad_per_cycle == 0
    assert state.from_rest
    assert state.from_rest.other
    assert not state.from_rest.reaches_reported
    assert state.from_rest.other.turn_rad_per_cycle == pytest.approx(-0.1974, rel=0.02)


def test_low_viscous_friction_leaves_two_motions() -> None:
    """Turns, rad a cycle, and travel, m, are those of runs over thousands of cycles.

    SciPy's DOP853 on equations written for it alone went the same way from rest.
    """
    gait = sn.Gait(1.0236161654969322, 1.7672253330280039, 1.275745173773889, -0.3307261500335363)
    state = sn.steady_gait(
        sn.Robot(4, 0.07487664366040801, 0.09878880239308058),
        sn.Ground(0.0013045297808168088, 8.07019160900096e-05),
        gait,
        from_rest=True,
    )
    reported_rad, other_rad = 0.07703, -0.023744
    assert state.turn_rad_per_cycle == pytest.approx(reported_rad, rel=0.01)
    assert state.from_rest
    other = state.from_rest.other
    assert other
    apart_rad = abs(other_rad - reported_rad)
    assert other.turn_rad_per_cycle == pytest.approx(other_rad, abs=0.01 * apart_rad)
    assert other.chord_m_s * gait.period_s == pytest.approx(0.040362, rel=0.03)
    assert state.to_dict()["from_rest"]["other"]["chord_m_s"] == other.chord_m_s


LOW_FRICTION = (
    sn.Robot(6, 0.020182246925280027, 0.1009668023718183),
    sn.Ground(0.0004348440967577329, 5.047746671006992e-05),
    sn.Gait(1.4359521669716155, 1.7275144350438132, 3.1678764962630646, 0.3504755348427641),
)
BENT = sn.Gait(1.2, 1.3, 5.0, 0.1)
ONE_STATE = (
    (OF_2005, sn.Ground(0.02, 0.3, 0.02, 0.05), BENT),
    (OF_2005, sn.Ground((0.02, 0.2), 0.3), BENT),
    LOW_FRICTION,  # a start that moves may lead elsewhere
)


@pytest.mark.parametrize("parts", ONE_STATE, ids=["dry", "ratchet", "low friction"])
def test_a_start_from_rest_that_reaches_the_state_says_so(parts: tuple) -> None:
    state = sn.steady_gait(*parts, from_rest=True)
    assert state.from_rest
    assert state.from_rest.reaches_reported
    assert state.from_rest.other is None
