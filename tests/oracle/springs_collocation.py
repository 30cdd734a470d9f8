"""The implicit model again, for springs of any stiffness: energies, collocation, long doubles.

Nothing but two scalar functions says what the model is: the springs' energy U(q) and half the loss
D(q, q') of dampers and wheels, over every link's own (x, y, theta). The forces -dU/dq - dD/dq' come
from complex steps. Imposed joint angles leave theta_1 free: q = S u + angles(t). Each step is one
collocation polynomial (Radau nodes) whose residuals are long doubles; only the Newton matrix,
which needs few digits, is a double. So a gap of 1e-9 m between centres a metre away has ten digits.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.polynomial.legendre import Legendre

from .params import Array, Gait, Params

Long = np.longdouble
_H = Long(1e-30)  # of complex steps: exact to rounding


def radau_nodes(stages: int) -> tuple[Array, Array]:
    """Return the nodes (s,) in (0, 1] and the matrix (s, s) of integrals from 0 to each node."""
    P = Legendre.basis
    rough = (P(stages) - P(stages - 1)).roots()
    x = np.sort(rough.real).astype(Long)
    for _ in range(4):  # Newton: to the last digit of a long double
        value, slope = _legendre_ends(x, stages)
        x[:-1] -= (value / slope)[:-1]
    x[-1] = 1
    powers = x[:, None] ** np.arange(stages)  # of the interval -1..1
    above = np.arange(1, stages + 1)
    up = (x[:, None] ** above - Long(-1) ** above) / above.astype(Long)
    return (1 + x) / 2, _solve_long(powers.T, up.T).T / 2


def _legendre_ends(x: Array, s: int) -> tuple[Array, Array]:
    """Return P_s - P_(s-1) and its slope at x, by the three-term recurrence."""
    p = [np.ones_like(x), x]
    for k in range(1, s):
        p.append(((2 * k + 1) * x * p[k] - k * p[k - 1]) / Long(k + 1))
    slope = [s * (x * p[s] - p[s - 1]), (s - 1) * (x * p[s - 1] - p[s - 2])]
    inside = np.where(x == 1, Long(2), x)
    return p[s] - p[s - 1], (slope[0] - slope[1]) / (inside**2 - 1)


def _solve_long(a: Array, b: Array) -> Array:
    """Solve a x = b in long doubles: a double's inverse, refined."""
    inverse = np.linalg.inv(a.astype(float)).astype(Long)
    x = inverse @ b
    for _ in range(20):
        x = x + inverse @ (b - a @ x)
    return x


class Springs:
    """Hold a chain on springs under a gait, or under torques of time."""

    def __init__(
        self, p: Params, k: float, c: float, gait: Gait | None, torque: Callable | None = None
    ) -> None:
        self.p, self.k, self.c, self.gait, self.torque = p, k, c, gait, torque
        n = p.links
        free = np.ones((n, 1)) if gait is not None else np.eye(n)
        self.S = np.zeros((3 * n, 2 * n + free.shape[1]))  # q = (x_i, y_i, theta_i) by kind
        self.S[: 2 * n, : 2 * n], self.S[2 * n :, 2 * n :] = np.eye(2 * n), free
        self.mass = np.repeat([p.mass_kg, p.mass_kg, p.inertia], n)

    def gaps(self, q: Array) -> Array:
        """Return the joints' gaps (2 (n-1), ...) of places q (3n, ...)."""
        x, y, a = np.split(q, 3)
        half = Long(self.p.half_length_m)
        ends = np.stack([x + half * np.cos(a), y + half * np.sin(a)])
        starts = np.stack([x - half * np.cos(a), y - half * np.sin(a)])
        return (starts[:, 1:] - ends[:, :-1]).reshape(-1, *q.shape[1:])

    def slips(self, q: Array, v: Array) -> tuple[Array, Array]:
        """Return the centres' speeds along and across their links, each (n, ...)."""
        (x, y, _), a = np.split(v, 3), np.split(q, 3)[2]
        return np.cos(a) * x + np.sin(a) * y, np.cos(a) * y - np.sin(a) * x

    def imposed(self, t: Array) -> tuple[Array, Array, Array]:
        """Return what time adds to q, q', q'' (3n,) each."""
        out = np.zeros((3, 3 * self.p.links), dtype=Long)
        if self.gait is not None:
            phase = self.gait.omega_rad_s * t + np.arange(self.p.links - 1) * Long(
                self.gait.beta_rad
            )
            g, w = Long(self.gait.alpha_rad), Long(self.gait.omega_rad_s)
            rows = (
                g * np.sin(phase) + self.gait.offset_rad,
                g * w * np.cos(phase),
                -g * w * w * np.sin(phase),
            )
            out[:, 2 * self.p.links + 1 :] = np.cumsum(rows, axis=1)
        return out[0], out[1], out[2]

    def pull(self, t: Long, q: Array, v: Array) -> tuple[Array, Array, Array]:
        """Return the forces (3n,) at q, q' (3n,), and minus their slopes (3n, 3n) by q and q'.

        The slopes leave out what does not grow with the springs: Newton's method bears that.
        """
        p, n = self.p, self.p.links
        steps = 1j * _H * np.eye(3 * n, dtype=Long)
        opening = self.gaps(q[:, None] + steps).imag / _H  # of each gap by each place
        rate = self.gaps(q + 1j * _H * v).imag / _H
        along, across = self.slips(q[:, None], v[:, None] + steps)
        loss = (p.ct * along**2 + p.cn * across**2).sum(axis=0) / Long(2)
        force = -(self.k * self.gaps(q) + self.c * rate) @ opening - loss.imag / _H
        force[:n] += p.mass_kg * p.gravity_m_s2[0]
        force[n : 2 * n] += p.mass_kg * p.gravity_m_s2[1]
        if self.torque is not None:
            turn = np.asarray(self.torque(float(t)), dtype=Long)
            force[2 * n : -1] += turn
            force[2 * n + 1 :] -= turn
        square = opening.T.astype(float) @ opening.astype(float)
        return force, self.k * square, self.c * square + np.diag(self._wheels())

    def _wheels(self) -> Array:
        """Return a bound of what wheels take from each rate (3n,): enough for a Newton matrix."""
        n = self.p.links
        return np.concatenate([np.full(2 * n, self.p.cn), np.zeros(n)])


def advance(
    springs: Springs, u: Array, rate: Array, t: float, h: float, stages: int = 8
) -> tuple[Array, Array]:
    """Return u, u' after one step of h seconds by a collocation polynomial of so many stages."""
    node, A = radau_nodes(stages)
    S, mass, h, t = springs.S, springs.mass.astype(Long), Long(h), Long(t)
    hA, square = h * A, h * h * (A @ A)
    accel = np.zeros((stages, u.size), dtype=Long)
    for _ in range(60):
        places, rates = u + h * node[:, None] * rate + square @ accel, rate + hA @ accel
        wrong, stiff, damped = np.empty_like(accel), [], []
        for j, x in enumerate(node):
            more = springs.imposed(t + h * x)
            force, K, C = springs.pull(t + h * x, S @ places[j] + more[0], S @ rates[j] + more[1])
            wrong[j] = S.T @ (mass * (S @ accel[j] + more[2]) - force)
            stiff.append(S.T @ K @ S)
            damped.append(S.T @ C @ S)
        inner = S.T @ np.diag(springs.mass) @ S
        matrix = np.einsum("ij,iab->iajb", square.astype(float), np.array(stiff))
        matrix += np.einsum("ij,iab->iajb", hA.astype(float), np.array(damped))
        matrix += np.einsum("ij,ab->iajb", np.eye(stages), inner)
        size = accel.size
        move = np.linalg.solve(matrix.reshape(size, size), wrong.astype(float).ravel())
        accel -= move.reshape(accel.shape)
        if abs(move).max() <= 1e-13 * max(1.0, float(abs(accel).max())):
            break
    else:
        raise RuntimeError(f"no convergence at t = {t}: {abs(move).max()}")
    return (u + h * rate + (square @ accel)[-1], rate + (hA @ accel)[-1])


def run(
    springs: Springs, q: Array, v: Array, duration_s: float, steps: int, stages: int = 8
) -> tuple[Array, Array]:
    """Return places and rates (3n,) of all links at the end of a run from q, v (3n,) at t = 0."""
    first, S = springs.imposed(Long(0)), springs.S
    pick = np.argmax(S, axis=0)  # a row that has the unknown itself
    u, rate = (q - first[0])[pick].astype(Long), (v - first[1])[pick].astype(Long)
    h = Long(duration_s) / steps
    for i in range(steps):
        u, rate = advance(springs, u, rate, i * h, h, stages)
    last = springs.imposed(Long(duration_s))
    return S @ u + last[0], S @ rate + last[1]
