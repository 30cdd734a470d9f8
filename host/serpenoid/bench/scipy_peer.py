"""SciPy's solve_ivp on both models in plain NumPy: what a user has without this package.

State, explicit: x, y, theta of link 1 and their rates. Implicit: x, y, vx, vy of all links (n
values each), then theta and its rate of link 1. The exact model is Newton's law of all links,
projected on the three free coordinates by dense matrices; the core sums over the links instead.
Dry friction: the sign is smoothed, v / sqrt(v^2 + width^2), since solve_ivp wants a continuous
right-hand side.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..model.gait import joint_motion
from .problems import Array, Problem

METHODS = ("RK45", "DOP853", "LSODA", "Radau", "BDF")
Rate = Callable[[float, Array], Array]


def equations(problem: Problem, width_m_s: float = 0.0) -> Rate:
    """Return y' = f(t, y) of a problem; width_m_s: of the smoothed sign, 0: none."""
    scene = problem.scene
    robot, ground, gait = scene.robot, scene.ground, scene.gait
    n, mass, inertia = robot.links, robot.link_mass_kg, robot.inertia_kg_m2
    half = robot.link_length_m / 2
    # x of all links = x of link 1 + arms @ cos(angles): half of the first and of the last link
    # on the way, all of those between
    arms = half * (np.tri(n) + np.tri(n, k=-1))
    arms[:, 0] = half * (np.arange(n) > 0)
    arms[0] = 0.0

    def shape(t: float, theta: float, omega: float) -> tuple[Array, Array, Array]:
        """Return angles of all links, their rates, and accelerations but for that of link 1."""
        angle, rate, turn = (np.append(0.0, part.cumsum()) for part in joint_motion(gait, n - 1, t))
        return theta + angle, omega + rate, turn

    def sign(v: Array) -> Array:
        return v / np.sqrt(v * v + width_m_s**2) if width_m_s > 0 else np.sign(v)

    def friction(c: Array, s: Array, vx: Array, vy: Array) -> tuple[Array, Array]:
        """Return the ground's force on each link, along x and y."""
        along, across = c * vx + s * vy, c * vy - s * vx
        ct = np.where(along > 0, ground.ct_forward, ground.ct_backward)
        ft0 = np.where(along > 0, ground.ft0_forward, ground.ft0_backward)
        ft = -ct * along - ft0 * sign(along)
        fn = -ground.cn * across - ground.fn0 * sign(across)
        return ft * c - fn * s, ft * s + fn * c

    def explicit(t: float, y: Array) -> Array:
        angles, rates, turns = shape(t, y[2], y[5])
        c, s, unit, none = np.cos(angles), np.sin(angles), np.ones(n), np.zeros(n)
        by_x = np.stack([unit, none, -arms @ s])  # x of all links by x, y and theta of link 1
        by_y = np.stack([none, unit, arms @ c])
        vx, vy = y[3] - arms @ (s * rates), y[4] + arms @ (c * rates)
        rest_x = -arms @ (s * turns + c * rates**2)  # acceleration while link 1's is 0
        rest_y = arms @ (c * turns - s * rates**2)
        fx, fy = friction(c, s, vx, vy)
        masses = mass * (by_x @ by_x.T + by_y @ by_y.T)
        masses[2, 2] += n * inertia
        force = by_x @ (fx - mass * rest_x) + by_y @ (fy - mass * rest_y)
        force[2] -= inertia * turns.sum()
        return np.concatenate([y[3:], np.linalg.solve(masses, force)])

    def implicit(t: float, y: Array) -> Array:
        angles, rates, turns = shape(t, y[4 * n], y[4 * n + 1])
        c, s = np.cos(angles), np.sin(angles)
        x, y_links, vx, vy = y[: 4 * n].reshape(4, n)
        meets = np.eye(n - 1, n) + np.eye(n - 1, n, k=1)
        apart = np.eye(n - 1, n, k=1) - np.eye(n - 1, n)
        arm_x, arm_y = half * meets @ c, half * meets @ s
        rate_x = apart @ vx + half * meets @ (s * rates)
        rate_y = apart @ vy - half * meets @ (c * rates)
        k, d = scene.joint_stiffness_n_m, scene.joint_damping_n_s_m
        pull_x = k * (apart @ x - arm_x) + d * rate_x
        pull_y = k * (apart @ y_links - arm_y) + d * rate_y
        fx, fy = friction(c, s, vx, vy)
        ax, ay = ((f - apart.T @ p) / mass for f, p in ((fx, pull_x), (fy, pull_y)))
        couple = arm_x @ pull_y - arm_y @ pull_x
        spin = (couple - inertia * turns.sum()) / (n * inertia)
        return np.concatenate([vx, vy, ax, ay, [y[4 * n + 1], spin]])

    return implicit if problem.soft else explicit


def solve(problem: Problem, method: str, tolerance: float, width_m_s: float = 0.0) -> Array:
    """Return the end state by a method of solve_ivp; raises ArithmeticError where it fails."""
    from scipy.integrate import solve_ivp

    solution = solve_ivp(
        equations(problem, width_m_s),
        (0, problem.scene.duration_s),
        problem.vector(problem.start),
        method,
        rtol=max(tolerance, 1e-13),
        atol=tolerance / 10,
    )
    if not solution.success:
        raise ArithmeticError(solution.message)
    return solution.y[:, -1]
