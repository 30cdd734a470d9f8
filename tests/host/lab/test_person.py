"""A person at the lab's treadmill holds what can be held, and is carried off where it cannot."""

from __future__ import annotations

import math

import numpy as np
import pytest
from robots import OF_2005
from serpenoid import Ground
from serpenoid.lab.belt import Belt
from serpenoid.lab.person import Person
from serpenoid.lab.robot import LabRobot, pose_of

WHOLE = Ground(0.084, 1.2, 0.14, 0.27)
STRAIGHT, BALANCED = (0,) * 6, (1, -1, 0, 0, -1, 1)


def person(seed, signs, bend_deg, incline_deg):
    rng = np.random.default_rng(seed)
    robot = LabRobot.whole_body(OF_2005, WHOLE).drawn(rng, math.radians(1.0))
    belt = Belt(robot)
    belt.tilt(math.radians(incline_deg))
    belt.pose(pose_of(signs, math.radians(bend_deg)))
    return Person(belt, rng)


@pytest.mark.parametrize(
    ("signs", "bend_deg", "incline_deg"),
    [(STRAIGHT, 0, 2.4), (BALANCED, 7.5, 2.8), (BALANCED, 15, 3.0), (BALANCED, 30, 5.0)],
)
def test_whoever_steers_holds_straight_and_balanced(signs, bend_deg, incline_deg):
    turned = []
    for seed in range(8):
        someone = person(seed, signs, bend_deg, incline_deg)
        station = someone.hold(0.4, 16.0)
        assert station is not None
        assert abs(station.drift_m_s) < 0.03
        assert not someone.belt.lost
        turned.append(math.degrees(someone.belt.look().heading_rad))
    assert np.sqrt(np.mean(np.square(turned))) < 3.0


def test_below_break_away_the_belt_carries_it_off():
    assert person(1, STRAIGHT, 0, 1.0).hold(0.2, 16.0) is None
