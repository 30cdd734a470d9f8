"""SciPy's plain equations agree with the dense ones and with the core."""

from __future__ import annotations

import numpy as np
import pytest
import serpenoid as sn
from oracle.scenes import SlowScene
from serpenoid.bench.problems import Array, Problem, problems
from serpenoid.bench.scipy_peer import equations


def dense_rates(problem: Problem, t: float, y: Array) -> Array:
    """Return y' of the peer's vector by the tests' dense equations."""
    slow, n = SlowScene(problem.scene), problem.scene.robot.links
    if problem.bodies == 1:
        return slow.rate(t, np.append(y[[0, 1, 4, 2, 3, 5]], np.zeros(4)))[[0, 1, 3, 4, 2, 5]]
    phi, phi_rate, _ = slow.joints(t)
    theta, omega = (np.append(y[k], y[k] + phi.cumsum()) for k, phi in ((-2, phi), (-1, phi_rate)))
    x, y_links, vx, vy = y[:-2].reshape(4, n)
    start = sn.LinkState(x, y_links, theta, vx, vy, omega)
    moved = slow.motion(t, slow.pack(start))[0]
    return np.concatenate([vx, vy, *moved.accel_m_s2.T, [y[-1], moved.theta_ddot[0]]])


@pytest.mark.parametrize("problem", problems(), ids=lambda p: p.name)
def test_plain_and_dense_rates_agree(problem: Problem) -> None:
    y = problem.vector(problem.start) + 0.01
    plain, dense = equations(problem)(0.4, y), dense_rates(problem, 0.4, y)
    # the dense system of 50 links loses some digits
    assert np.abs(plain - dense).max() < 1e-10 * np.abs(dense).max()
