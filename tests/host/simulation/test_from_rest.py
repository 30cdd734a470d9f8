"""A robot from rest may end in another motion than the state that is reported."""

from __future__ import annotations

import pytest
import serpenoid as sn
from robots import OF_2005
from serpenoid.simulation.from_rest import elsewhere

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
    )
    assert state.turn_rad_per_cycle == 0
    assert "a cycle turns -11.3 deg" in elsewhere(state)


@pytest.mark.parametrize("ground", [sn.Ground(0.02, 0.3, 0.02, 0.05), sn.Ground((0.02, 0.2), 0.3)])
def test_a_gait_with_one_state_says_nothing(ground: sn.Ground) -> None:
    robot = OF_2005
    assert not elsewhere(sn.steady_gait(robot, ground, sn.Gait(1.2, 1.3, 5.0, 0.1)))
