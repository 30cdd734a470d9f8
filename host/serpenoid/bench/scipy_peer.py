"""Both models in plain NumPy for SciPy's solve_ivp, as users would solve them without this package.

The state is x, y, vx, vy of link 1, or of all links if joints are springs (n values each), then
angle and rate of link 1. The exact model is Newton's law of all links, projected on the three free
coordinates by dense matrices; the core sums over the links instead. Positions, velocities and
forces are complex numbers, x + i y. The sign of dry friction is smoothed to v / sqrt(v^2 +
width^2), since solve_ivp needs a continuous right-hand side.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ..model.gait import joint_motion
from .problems import Array, Problem

METHODS = ("RK45", "DOP853", "LSODA", "Radau", "BDF")  # Methods of solve_ivp that are timed.
RightSide = Callable[[float, Array], Array]
Complex = NDArray[np.complex128]


def equations(problem: Problem, width_m_s: float = 0.0) -> RightSide:
    """Return f of y' = f(t, y) for a problem; width_m_s: width of the smoothed sign, 0 for none."""
    scene = problem.scene
    robot, ground, gait = scene.robot, scene.ground, scene.gait
    n, mass, inertia = robot.links, robot.link_mass_kg, robot.inertia_kg_m2
    half = robot.link_length_m / 2
    # The centre of a link is that of link 1 plus its row of arms @ directions: half of link 1, half
    # of the link itself, and all of the links between them.
    arms = half * (np.tri(n) + np.tri(n, k=-1))
    arms[:, 0] = half * (np.arange(n) > 0)
    arms[0] = 0.0

    def shape(t: float, theta: float, omega: float) -> tuple[Complex, Array, Array]:
        """Return the links' directions and rates, and their angular acceleration over link 1's."""
        angle, rate, acceleration = (
            np.append(0.0, part.cumsum()) for part in joint_motion(gait, n - 1, t)
        )
        return np.exp(1j * (theta + angle)), omega + rate, acceleration

    def sign(v: Array) -> Array:
        return v / np.sqrt(v * v + width_m_s**2) if width_m_s > 0 else np.sign(v)

    def friction(direction: Complex, velocity: Complex) -> Complex:
        """Return the ground's force on each link."""
        local = velocity * direction.conj()
        along, across = local.real, local.imag
        force = ground.ct_forward * along + ground.ft0_forward * sign(along)
        return -(force + 1j * (ground.cn * across + ground.fn0 * sign(across))) * direction

    def explicit(t: float, y: Array) -> Array:
        direction, rates, bending = shape(t, y[-2], y[-1])
        by_theta = arms @ (1j * direction)
        velocity = y[2] + 1j * y[3] + arms @ (1j * rates * direction)
        drift = arms @ ((1j * bending - rates**2) * direction)  # Accelerations if link 1 has none.
        force = friction(direction, velocity) - mass * drift
        columns = np.stack([np.ones(n), 1j * np.ones(n), by_theta])  # x, y and theta of link 1
        masses = mass * (columns.conj() @ columns.T).real
        masses[2, 2] += n * inertia
        forces = (columns.conj() @ force).real
        forces[2] -= inertia * bending.sum()
        *acceleration, angular = np.linalg.solve(masses, forces)
        return np.array([y[2], y[3], *acceleration, y[-1], angular])

    def implicit(t: float, y: Array) -> Array:
        direction, rates, bending = shape(t, y[-2], y[-1])
        x, y_links, vx, vy = y[: 4 * n].reshape(4, n)
        velocity = vx + 1j * vy
        arm = half * (direction[1:] + direction[:-1])
        arm_rate = half * 1j * (rates[1:] * direction[1:] + rates[:-1] * direction[:-1])
        pull = scene.joint_stiffness_n_m * (np.diff(x + 1j * y_links) - arm)
        pull += scene.joint_damping_n_s_m * (np.diff(velocity) - arm_rate)
        force = friction(direction, velocity) + np.diff(pull, prepend=0, append=0)
        acceleration = force / mass
        torque = float((arm.conj() @ pull).imag) - inertia * bending.sum()
        rate = [y[-1], torque / (n * inertia)]
        return np.concatenate([vx, vy, acceleration.real, acceleration.imag, rate])

    return implicit if scene.formulation == "implicit" else explicit


def solve(problem: Problem, method: str, tolerance: float, width_m_s: float = 0.0) -> Array:
    """Return the end state by a method of solve_ivp; raises ArithmeticError if it fails."""
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
