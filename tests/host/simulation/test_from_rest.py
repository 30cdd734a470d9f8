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


# robot, ground, gait of viscous ground that brakes and grips little; then whether a start from
# rest reaches the reported motion, the reported turn, rad a cycle, and turn and travel, m, of the
# other motion, by runs over thousands of cycles. SciPy's DOP853 on equations written for it alone
# went the same way from rest.
VISCOUS_PAIRS = [
    (
        (
            (4, 0.07487664366040801, 0.09878880239308058),
            (0.0013045297808168088, 8.07019160900096e-05),
            (1.0236161654969322, 1.7672253330280039, 1.275745173773889, -0.3307261500335363),
        ),
        False,
        0.07703,
        -0.023744,
        0.040362,
    ),
    (
        (
            (6, 0.020182246925280027, 0.1009668023718183),
            (0.0004348440967577329, 5.047746671006992e-05),
            (1.4359521669716155, 1.7275144350438132, 3.1678764962630646, 0.3504755348427641),
        ),
        True,
        -0.10034,
        -0.000998,
        0.078668,
    ),
]


@pytest.mark.parametrize("case", VISCOUS_PAIRS, ids=["rest to the other", "rest to the reported"])
def test_low_viscous_friction_leaves_two_motions(case: tuple) -> None:
    body, reaches_reported, reported_rad, other_rad, other_m = case
    robot, friction, gait = (sn.Robot(*body[0]), sn.Ground(*body[1]), sn.Gait(*body[2]))
    state = sn.steady_gait(robot, friction, gait, from_rest=True)
    assert state.turn_rad_per_cycle == pytest.approx(reported_rad, rel=0.01)
    assert state.from_rest
    assert state.from_rest.other
    assert state.from_rest.reaches_reported == reaches_reported
    apart_rad = abs(other_rad - reported_rad)
    other = state.from_rest.other
    assert other.turn_rad_per_cycle == pytest.approx(other_rad, abs=0.01 * apart_rad)
    assert other.chord_m_s * gait.period_s == pytest.approx(other_m, rel=0.03)
    assert state.to_dict()["from_rest"]["other"]["chord_m_s"] == other.chord_m_s


@pytest.mark.parametrize("ground", [sn.Ground(0.02, 0.3, 0.02, 0.05), sn.Ground((0.02, 0.2), 0.3)])
def test_a_gait_with_one_state_says_nothing(ground: sn.Ground) -> None:
    state = sn.steady_gait(OF_2005, ground, sn.Gait(1.2, 1.3, 5.0, 0.1), from_rest=True)
    assert state.from_rest
    assert state.from_rest.reaches_reported
    assert state.from_rest.other is None
