"""The periodic state of the spring-and-damper model, by shooting over a whole period.

The state seen from link 1's frame is its own velocities, and places and velocities of the others:
4n - 1 numbers. Newton with complex steps; no waiting for the springs to stop ringing.
"""

from __future__ import annotations

import numpy as np

from . import implicit
from .implicit import Spring
from .params import Array, Gait, Params


def from_link1(p: Params, y: Array) -> Array:
    """Return the state (4n - 1,) in link 1's frame of an angle-driven state y (4n + 2,)."""
    n = p.links
    cos, sin = np.cos(y[2 * n]), np.sin(y[2 * n])
    turn = np.array([[cos, sin], [-sin, cos]])
    place, speed = y[: 2 * n].reshape(n, 2), y[2 * n + 1 : -1].reshape(n, 2)
    others = (place[1:] - place[0]) @ turn.T
    return np.concatenate([others.ravel(), (speed @ turn.T).ravel(), y[-1:]])


def to_ground(state: Array) -> Array:
    """Return the angle-driven state (4n + 2,) with link 1 at the origin, heading 0."""
    return np.concatenate(
        [np.zeros(2), state[: (len(state) - 3) // 2], np.zeros(1), state[(len(state) - 3) // 2 :]]
    )


def march(p: Params, spring: Spring, gait: Gait, state: Array, rtol: float) -> Array:
    """Return the angle-driven state (4n + 2,) a period later."""
    rate, end = implicit.gait_rate(p, spring, gait), np.array([gait.period_s])
    return implicit.integrate(rate, to_ground(state), end, rtol=rtol)[-1]


def settle(p: Params, spring: Spring, gait: Gait, start: Array, rtol: float) -> tuple[Array, Array]:
    """Return the periodic state (4n - 1,) in link 1's frame and the period map's Jacobian."""
    state, step = np.asarray(start, float), 1e-30
    for _ in range(12):
        columns = [
            from_link1(p, march(p, spring, gait, state + 1j * step * axis, rtol))
            for axis in np.eye(len(state))
        ]
        jacobian = np.stack([column.imag / step for column in columns], -1)
        change = np.linalg.solve(np.eye(len(state)) - jacobian, columns[0].real - state)
        state = state + change
        if np.abs(change).max() < 100 * rtol * np.abs(state).max():
            return state, jacobian
    raise RuntimeError(f"no periodic state: last change {np.abs(change).max()}")


def speed(
    p: Params, spring: Spring, gait: Gait, u0: Array, rtol: float = 1e-11
) -> tuple[float, float]:
    """Return the mean speed, m/s, and the slowest multiplier's magnitude.

    u0 (3,), the exact model's velocities at t = 0, starts the search from the slow manifold.
    """
    phi, phi_dot, _ = gait.angles(0.0, p.links - 1)
    q = implicit.explicit.whole_state(np.zeros(3), phi)
    qdot = implicit.explicit.whole_state(u0, phi_dot)
    drive = implicit.gait_drive(p, gait)
    links = implicit.on_slow_manifold(p, spring, drive, 0.0, (q, qdot))
    state, jacobian = settle(p, spring, gait, from_link1(p, implicit.pack(*links)), rtol)
    first, last = to_ground(state), march(p, spring, gait, state, rtol)
    travel = (last - first)[: 2 * p.links].reshape(-1, 2).mean(0)
    return float(np.hypot(*travel)) / gait.period_s, float(
        np.abs(np.linalg.eigvals(jacobian)).max()
    )
