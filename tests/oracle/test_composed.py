"""A composed run is the same as going cycle by cycle."""

from __future__ import annotations

import cmath

import numpy as np
import pytest

from .composed import after, from_body


@pytest.mark.parametrize("bend", [0.0, 0.03])
def test_composed_cycles_are_cycles(bend: float) -> None:
    """Two links that go on in a circle or straight, and forget how they started."""

    def cycle(y: np.ndarray) -> np.ndarray:
        q, v = np.split(y.copy(), 2)
        own = from_body(y)
        turn, way = bend + 0.1 * own[5], (0.2 + 0.05j) * cmath.exp(1j * q[2])
        q[0::3] += way.real
        q[1::3] += way.imag
        centre = complex(q[0], q[1])
        place = (q[0::3] + 1j * q[1::3] - centre) * cmath.exp(1j * turn) + centre
        q[0::3], q[1::3], q[2::3] = place.real, place.imag, q[2::3] + turn
        v[2::3] *= 0.2  # what it forgets
        speed = (v[0::3] + 1j * v[1::3]) * cmath.exp(1j * turn)
        v[0::3], v[1::3] = speed.real, speed.imag
        return np.concatenate([q, v])

    y = np.array([0.1, 0.2, 0.3, 0.2, 0.2, 0.4, 0.01, 0.02, 0.5, 0.01, 0.02, 0.5])
    at, angle, gone = after(cycle, y, 500)
    assert gone < 40
    for _ in range(500):
        y = cycle(y)
    assert at == pytest.approx(complex(y[0], y[1]), abs=1e-9)
    assert angle == pytest.approx(y[2], abs=1e-9)
