"""Runs of thousands of cycles, by a few cycles of any reference: settled, each moves the same way.

Once the motion repeats as seen from the body, one cycle is one motion g of the plane, and after N
cycles the body is at g^N. A gait without an offset is its own mirror image half a cycle later: g
then turns by nothing, and what rounding turns it by is left out.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .params import Array

_NO_TURN = 1e-10  # rad a cycle: below, a turn is the error of the cycle


def from_body(y: Array) -> Array:
    """Return places and rates (q, v) of all links, (x, y, theta) each, as seen from link 1."""
    q, v = np.split(y, 2)
    turn = np.exp(-1j * q[2])
    place = ((q[0::3] - q[0]) + 1j * (q[1::3] - q[1])) * turn
    speed = (v[0::3] + 1j * v[1::3]) * turn
    parts = [place.real, place.imag, q[2::3] - q[2], speed.real, speed.imag, v[2::3]]
    return np.concatenate(parts)


def after(
    cycle: Callable[[Array], Array], y: Array, cycles: int, same: float = 1e-12
) -> tuple[complex, float, int]:
    """Return place, m, and angle, rad, of link 1 after many cycles from y, and those computed.

    `cycle` returns (q, v) one cycle later, at the same phase. The motion has settled when two
    cycles in a row differ by less than `same` in body lengths, radians and their rates.
    """
    gone, change = 0, np.inf
    before = y
    while gone < cycles and change > same:
        before, y, gone = y, cycle(y), gone + 1
        change = abs(from_body(y) - from_body(before)).max()
    bend = y[2] - before[2]
    bend = 0.0 if abs(bend) < _NO_TURN else bend
    step = complex(y[0] - before[0], y[1] - before[1]) * np.exp(-1j * y[2])  # as seen at its end
    left = cycles - gone
    # sum of step * exp(i (theta + j bend)), j = 1..left
    factor = left if bend == 0 else np.expm1(1j * left * bend) / np.expm1(1j * bend)
    way = step * np.exp(1j * (y[2] + bend)) * factor
    return complex(y[0], y[1]) + way, float(y[2] + left * bend), gone
