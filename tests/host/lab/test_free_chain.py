"""The lab's chain of locked joints against closed forms and conservation laws."""

from __future__ import annotations

import math

import numpy as np
import pytest
from serpenoid import _core

G, N, MASS, LENGTH = 9.81, 6, 0.0756, 0.076
WHOLE = (0.084, 1.2, 0.14, 0.27)


def chain(n=N, rolling=0.0):
    ct, cn, ft0, fn0 = (x / n for x in WHOLE)
    row = [ct, cn, ft0, fn0, ct, ft0, rolling, 1.0]
    return _core.LabChain(MASS, LENGTH, MASS * LENGTH**2 / 12, np.array([row] * n))


def placed(c, theta, belt=0.0, gamma=0.0, v=(0.0, 0.0), w=0.0):
    """Put a chain down with its links at theta, the mean one along x."""
    theta = np.asarray(theta, dtype=float)
    c.set_joints(list(np.diff(theta)))
    c.set_ground_velocity(-belt, 0.0)
    c.set_slope(G * math.sin(gamma), 0.0)
    c.place(0.0, 0.0, theta[0] - theta.mean(), *v, w)
    return c


@pytest.mark.parametrize("rolling", [0.0, 0.004])
def test_energy_of_a_push_becomes_heat(rolling):
    """The error is of the first order; a robot that rests has given all it had."""
    theta, left = np.array([2, -1, 0, 1, 2, -2]) * 0.1, []
    for h in (0.002, 0.001):
        c = placed(chain(rolling=rolling), theta, v=(0.6, 0.1), w=1.0)
        begun = c.kinetic_j
        c.advance(0.4, h)
        left.append((begun - c.kinetic_j - c.state[6]) / begun)
        c.advance(5.0, h)
        assert c.state[3:6] == pytest.approx((0.0, 0.0, 0.0), abs=1e-9)
    assert abs(left[0]) < 0.005
    assert left[1] == pytest.approx(left[0] / 2, rel=0.1)


@pytest.mark.parametrize("links", [3, 6])
def test_between_rails_a_robot_rolls_as_one_mass_even_where_it_was_pushed_askew(links):
    """Straight wheels are square to the rails: steered, they come to it and leave it again."""
    gamma, belt, push = math.radians(3), 0.4, 0.02
    c = placed(chain(links), [0.0] * links, belt, gamma, (push, 0.03), 0.05)
    c.guide(True)
    for offset in (0.004, -0.004, 0.0):
        c.aim([offset] * (links - 1), math.radians(45))
        assert c.advance(0.5, 0.004)
    assert c.state[1:3] == pytest.approx((0.0, 0.0), abs=1e-12)
    c = placed(chain(links), [0.0] * links, belt, gamma, (push, 0.0))
    c.guide(True)
    assert c.advance(2.0, 0.001)
    mass, (ct, _, ft0, _) = links * MASS, WHOLE
    end = (mass * G * math.sin(gamma) - ft0) / ct
    slip = end + (belt + push - end) * math.exp(-ct / mass * 2.0)
    assert c.state[3] + belt == pytest.approx(slip, rel=2e-3)
