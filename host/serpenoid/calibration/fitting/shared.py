"""What all readings share: the scale of the belt's speed, the mass, and a robot not quite straight.

Scales. The law m g sin(gamma) = A v + B stays the same when a mass k times as large makes every
friction k times as large, and when a belt k times as fast makes ct and cn k times as small. So no
station can tell either: their errors add in quadrature to what the readings leave.

Straightness. A link that stands delta off its path slips across it, however slowly, so that dry
friction across drags it back with fn0 / n |sin delta|: always in the same sense, and to first
order. With joints off by independent errors of sigma, the links' angles are their sums; the robot
is steered, so that its mean heading and its mean curvature are taken off. What is left has the
covariance S, and the mean of |delta| over the links is a sigma on average and scatters by b sigma:

    a = sqrt(2/pi) mean(s_i),   b^2 = (2/pi) / n^2 sum s_i s_j (sqrt(1 - rho^2) + rho asin rho - 1),

s_i^2 = S_ii, rho = S_ij / (s_i s_j). Links that are bent by more than delta gain on one side what
they lose on the other: to first order their dry friction does not tell where the robot heads. So in
a bend it is the straight links alone that heading and curvature follow; two of them lie along the
path exactly, and only where there are three is something left.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

FRICTIONS = ("ct", "cn", "ft0", "fn0")  # the whole snake's, in their order
# A wheel's J / r^2 over its mass: 0.5 for a disc, 1 for a ring; with the spread of what is sold.
WHEEL_SHAPE = (0.75, 0.15)
# Where nobody told what the wheels weigh: their J / r^2 over the robot's mass.
UNTOLD = (0.045, 0.03)


def straightness_factors(links: int, bent: int = 0) -> tuple[float, float]:
    """Return a and b: mean and scatter of the straight links' mean |delta|, per sigma of a joint.

    links: number of links. bent: how many of them are bent, evenly many at either end. Two straight
    links lie along any path that is steered: 0 and 0.
    """
    straight = links - bent
    if straight < 3:
        return 0.0, 0.0
    place = bent / 2 + np.arange(straight, dtype=float)
    joints_before = np.minimum.outer(place, place)
    steered = np.column_stack([np.ones(straight), place])
    off = np.eye(straight) - steered @ np.linalg.pinv(steered)
    covariance = off @ joints_before @ off.T
    s = np.sqrt(np.diag(covariance))
    rho = np.clip(covariance / np.outer(s, s), -1.0, 1.0)
    shape = np.sqrt(1.0 - rho**2) + rho * np.arcsin(rho) - 1.0
    scatter = math.sqrt(2 / math.pi * float(s @ shape @ s)) / straight
    return math.sqrt(2 / math.pi) * float(s.mean()), scatter


def shared_covariance(values: Floats, belt_sigma: float, mass_sigma: float) -> Floats:
    """Return what belt and mass add to the covariance of the frictions (P, P), whole snake.

    values: (P,) in the order ct, cn, ft0, fn0 (, ct and ft0 backwards). belt_sigma, mass_sigma:
    relative standard deviations.
    """
    viscous = np.array([1.0, 1.0, 0.0, 0.0, 1.0, 0.0])[: len(values)] * values
    return mass_sigma**2 * np.outer(values, values) + belt_sigma**2 * np.outer(viscous, viscous)


def scaled(whole: Floats, belt_sigma: float, mass_sigma: float, seed: int = 2005) -> Floats:
    """Return draws of frictions (N, P) with errors of belt and mass in them, log-normal ones."""
    belt, mass = np.random.default_rng(seed).normal(size=(2, len(whole), 1))
    viscous = np.array([True, True, False, False, True, False])[: whole.shape[1]]
    return np.asarray(whole * np.exp(mass_sigma * mass - np.where(viscous, belt_sigma, 0.0) * belt))


def rolling_share(wheels_kg: float | None, mass_kg: float) -> tuple[float, float]:
    """Return J / r^2 of all wheels over the robot's mass, and its standard deviation."""
    if wheels_kg is None:
        return UNTOLD
    mean, sigma = WHEEL_SHAPE
    return mean * wheels_kg / mass_kg, sigma * wheels_kg / mass_kg
