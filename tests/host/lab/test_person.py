"""A person at the lab's treadmill holds what can be held, and is carried off where it cannot."""

from __future__ import annotations

import math

import numpy as np
import pytest
from robots import OF_2005
from serpenoid import Ground
from serpenoid.lab.belt import Belt
from serpenoid.lab.person import Display, Habits, Person
from serpenoid.lab.robot import LabRobot, pose_of

WHOLE = Ground(0.084, 1.2, 0.14, 0.27)
STRAIGHT, BALANCED = (0,) * 6, (1, -1, 0, 0, -1, 1)


def person(seed, signs, bend_deg, incline_deg, joint_deg=1.0, **habits):
    rng = np.random.default_rng(seed)
    robot = LabRobot.whole(OF_2005, WHOLE).drawn(rng, math.radians(joint_deg))
    belt = Belt(robot)
    belt.tilt(math.radians(incline_deg))
    belt.pose(pose_of(signs, math.radians(bend_deg)))
    return Person(belt, rng, Habits(**habits))


def held(seeds, *lies, **more):
    return [person(seed, *lies, **more).hold(0.4, 16.0) for seed in seeds]


@pytest.mark.parametrize(
    ("signs", "bend_deg", "incline_deg"),
    [(STRAIGHT, 0, 2.4), (BALANCED, 7.5, 2.8), (BALANCED, 15, 3.0), (BALANCED, 30, 5.0)],
)
def test_whoever_steers_holds_straight_and_balanced(signs, bend_deg, incline_deg):
    for station in (found := held(range(8), signs, bend_deg, incline_deg)):
        assert station is not None
        assert abs(station.drift_m_s) < 0.03
        assert max(abs(s.across_m) for s in station.seen) < 0.22
    turned = [math.degrees(s.seen[-1].heading_rad) for s in found]
    assert np.sqrt(np.mean(np.square(turned))) < 3.0


def test_below_break_away_the_belt_carries_it_off():
    assert person(1, STRAIGHT, 0, 1.0).hold(0.2, 16.0) is None


def test_the_same_seed_does_the_same_and_a_display_that_is_off_shows():
    one, two = (held([3], STRAIGHT, 0, 2.4)[0] for _ in range(2))
    assert one == two
    assert one is not None
    off = person(3, STRAIGHT, 0, 2.4)
    off.display = Display(scale=1.1)
    found = off.hold(0.4, 16.0)
    assert found is not None
    ratio = (one.belt_shown_m_s - one.drift_m_s) / (found.belt_shown_m_s - found.drift_m_s / 1.1)
    assert ratio == pytest.approx(1.1, abs=0.04)
