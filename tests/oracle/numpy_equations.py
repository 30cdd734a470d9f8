"""The two models in plain vectorised NumPy."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from serpenoid.bench.problems import Array, Problem

Rate = Callable[[float, Array], Array]


def rate_of(problem: Problem, width_m_s: float = 0.0) -> Rate:
    """Return y' = f(t, y); dry friction smoothed by width_m_s (0: the plain sign)."""
    robot, ground, gait = problem.robot, problem.ground, problem.gait
    n, m, half = robot.links, robot.link_mass_kg, robot.link_length_m / 2
    inertia, w = robot.link_inertia_kg_m2 or 0.0, gait.omega_rad_s
    lag = gait.beta_rad * np.arange(n - 1)

    def before(joints: Array) -> Array:
        return np.concatenate(([0.0], np.cumsum(joints)))

    def bend(t: float) -> tuple[Array, Array, Array]:
        wave = gait.alpha_rad * np.sin(w * t + lag)
        rate = w * gait.alpha_rad * np.cos(w * t + lag)
        return before(gait.offset_rad + wave), before(rate), before(-w * w * wave)

    def sign(v: Array) -> Array:
        return v / np.sqrt(v * v + width_m_s**2) if width_m_s > 0 else np.sign(v)

    def friction(c: Array, s: Array, vx: Array, vy: Array) -> tuple[Array, Array]:
        vt, vn = c * vx + s * vy, c * vy - s * vx
        ct = np.where(vt > 0, ground.ct_forward, ground.ct_backward)
        ft0 = np.where(vt > 0, ground.ft0_forward, ground.ft0_backward)
        ft, fn = -ct * vt - ft0 * sign(vt), -ground.cn * vn - ground.fn0 * sign(vn)
        return ft * c - fn * s, ft * s + fn * c

    def explicit(t: float, y: Array) -> Array:
        shape, rate, turn = bend(t)
        theta, omega = y[2] + shape, y[5] + rate
        c, s = np.cos(theta), np.sin(theta)
        rx, ry = before(half * (c[1:] + c[:-1])), before(half * (s[1:] + s[:-1]))
        ux, uy = -omega * s, omega * c
        vx, vy = y[3] + before(half * (ux[1:] + ux[:-1])), y[4] + before(half * (uy[1:] + uy[:-1]))
        ex, ey = -turn * s - omega**2 * c, turn * c - omega**2 * s
        bx, by = before(half * (ex[1:] + ex[:-1])), before(half * (ey[1:] + ey[:-1]))
        fx, fy = friction(c, s, vx, vy)
        qx, qy = fx - m * bx, fy - m * by
        Rx, Ry = m * rx.sum(), m * ry.sum()
        J = n * inertia + m * (rx @ rx + ry @ ry)
        mass = np.array([[n * m, 0, -Ry], [0, n * m, Rx], [-Ry, Rx, J]])
        load = np.array([qx.sum(), qy.sum(), rx @ qy - ry @ qx - inertia * turn.sum()])
        return np.concatenate((y[3:], np.linalg.solve(mass, load)))

    def implicit(t: float, y: Array) -> Array:
        x, yy, vx, vy = y[: 4 * n].reshape(4, n)
        shape, rate, turn = bend(t)
        theta, omega = y[4 * n] + shape, y[4 * n + 1] + rate
        c, s = np.cos(theta), np.sin(theta)
        cc, ss = half * (c[1:] + c[:-1]), half * (s[1:] + s[:-1])
        us, uc = half * omega * s, half * omega * c
        k, d = problem.stiffness_n_m, problem.damping_n_s_m
        fx = k * (np.diff(x) - cc) + d * (np.diff(vx) + us[1:] + us[:-1])
        fy = k * (np.diff(yy) - ss) + d * (np.diff(vy) - uc[1:] - uc[:-1])
        ax, ay = friction(c, s, vx, vy)
        ax[:-1] += fx
        ax[1:] -= fx
        ay[:-1] += fy
        ay[1:] -= fy
        spin = (fy @ cc - fx @ ss - inertia * turn.sum()) / (n * inertia)
        return np.concatenate((vx, vy, ax / m, ay / m, [y[4 * n + 1], spin]))

    return implicit if problem.implicit else explicit
