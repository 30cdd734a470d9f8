"""Shapes of gaits: their coordinates, what a search knows of one, and the rate for a speed."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from ..model.gait import Gait

Array = NDArray[np.float64]
COSTS = ("power", "abs_power", "positive_power")  # mean powers that a search makes least
_DEARER = 60.0  # e-folds of cost for an e-fold beyond a limit: cost never falls so fast beyond one
RATE_STEP = 1.6  # from rate to rate of a table: lines between them err by a few per cent
STATES, FINE = 1e-3, 1e-5  # accuracy of dry states while a search goes on, and of its answer


def shape_of(alpha_rad: float, beta_rad: float) -> Array:
    """Return the coordinates of the search: ln of the links' amplitude, and ln tan(beta / 2).

    The amplitude of the links' headings, alpha / (2 sin(beta / 2)), matters more than that of the
    joints. Near a standing wave, what pushes is how far beta is from 180 degrees.
    """
    return np.log([alpha_rad / (2 * math.sin(beta_rad / 2)), math.tan(beta_rad / 2)])


def angles_of(shape: Array) -> tuple[float, float]:
    """Return amplitude and lag of the joints, rad."""
    swing, tangent = np.exp(shape).tolist()
    beta = 2 * math.atan(tangent)
    return 2 * swing * math.sin(beta / 2), beta


@dataclass(frozen=True)
class Point:
    """Hold a shape's gait at the wanted speed, ln of its cost, and its least margin to a limit.

    gait: None where no rate gives the speed. margin: e-folds, below 0 beyond a limit, or by how
    much the speed is missed. state: the state there, where it may begin those near it.
    """

    shape: Array
    gait: Gait | None = None
    value: float = _DEARER
    margin: float = -1.0
    state: Any = None

    @property
    def rate(self) -> float:
        """Return the gait's rate, rad/s."""
        assert self.gait is not None
        return self.gait.omega_rad_s

    @property
    def price(self) -> float:
        """Return what a search makes least: beyond a limit more than the cost."""
        return self.value - _DEARER * min(self.margin, 0.0)


def better(point: Point) -> tuple[bool, float]:
    """Return the key that orders points: those within the limits first."""
    return (point.margin < 0, point.price)


def near_root(
    function: Callable[[float], float], guess: float, most_miss: float, slope: float = 1.0
) -> list[float]:
    """Return the places looked at for a function's root near a guess, nearest to 0 first.

    Steps to both sides, each twice as far, until a root lies between; then Brent's method.
    slope: the one expected. There may be no root: a function may turn, or jump over 0.
    """
    known: dict[float, float] = {}

    def miss(x: float) -> float:
        if x not in known:
            known[x] = function(x)
        return 0.0 if abs(known[x]) < most_miss else min(max(known[x], -9.0), 9.0)

    first = miss(guess)
    # shorter first steps drown in the errors of states
    step = math.copysign(max(1.5 * abs(first / slope), 3 * STATES), -first)
    while abs(step) < math.log(RATE_STEP) and not miss(guess + step) * first <= 0:
        step *= -2
    with suppress(ValueError):  # no root between, or no value
        brentq(miss, guess, guess + step, xtol=most_miss / 10)
    return sorted((x for x in known if math.isfinite(known[x])), key=lambda x: abs(known[x]))


def rate_at_speed(
    state: Callable[[float], tuple[float, float]], guess: float, most_miss: float
) -> tuple[float, float, float] | None:
    """Return the ln rate near a guess that gives the speed, ln of the cost there, and the miss.

    state: returns ln of the speed over the wanted one, and ln of the cost, at an ln rate. A line
    between the two nearest rates puts a small miss right. A greater one stays where no rate gives
    the speed, or only one behind a fold; it leads a search to shapes that give the speed.
    """
    state = cache(state)
    places = near_root(lambda x: state(x)[0], guess, most_miss)
    if len(places) < 2:
        return None

    def short(x: float) -> float:
        miss, cost = state(x)
        return cost + _DEARER * abs(miss)

    (y, cost), (y0, cost0) = state(places[0]), state(places[1])
    x = min(places, key=short)
    if abs(y) > most_miss or x != places[0]:
        return x, state(x)[1], abs(state(x)[0])
    part = y / (y - y0)
    return places[0] + part * (places[1] - places[0]), cost + part * (cost0 - cost), 0.0
