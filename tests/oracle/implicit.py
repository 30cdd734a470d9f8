"""The paper's implicit model (Eqs. 51-56): free links held together by springs and dampers.

The state is every link's own (x_i, y_i, theta_i) and rates; Eq. 51-52 gives the joint force
F_i = k gap_i + c gap_i' on link i from link i+1. An imposed joint angle stays an exact constraint
theta_{i+1} - theta_i = phi_i(t), whose multiplier is T_i, solved as one dense system.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

from . import explicit
from .explicit import Motion, angle_rows, axes
from .params import Array, Gait, Params


@dataclass(frozen=True)
class Spring:
    """Hold the joints' stiffness and damping: one value, or one for each joint."""

    stiffness_n_m: float | Array = 1000.0
    damping_n_s_m: float | Array = 1.0

    def columns(self, links: int) -> tuple[Array, Array]:
        """Return stiffness and damping joint by joint, each (n-1, 1)."""
        pair = self.stiffness_n_m, self.damping_n_s_m
        stiffness, damping = (np.broadcast_to(value, links - 1)[:, None] for value in pair)
        return stiffness, damping


def joint_gaps(p: Params, pose: Array, rates: Array) -> tuple[Array, Array]:
    """Return the gaps and their rates (n-1, 2) of links with pose and rates (n, 3) (Eqs. 53-56)."""
    tangent, normal = axes(pose[:, 2])
    arm, arm_rate = p.half_length_m * tangent, p.half_length_m * normal * rates[:, 2:]
    gap = (pose[1:, :2] - arm[1:]) - (pose[:-1, :2] + arm[:-1])
    return gap, (rates[1:, :2] - arm_rate[1:]) - (rates[:-1, :2] + arm_rate[:-1])


def joint_forces(
    p: Params, spring: Spring, pose: Array, rates: Array, gap_rate: Array | None = None
) -> Array:
    """Return F_i (n-1, 2) (Eqs. 51-52); `gap_rate` is what dampers act on if not the present."""
    gap, live = joint_gaps(p, pose, rates)
    gap_rate = live if gap_rate is None else gap_rate
    stiffness, damping = spring.columns(p.links)
    return stiffness * gap + damping * gap_rate


def evaluate(
    p: Params,
    spring: Spring,
    pose: Array,
    rates: Array,
    *,
    torque: Array,
    phi_ddot: Array,
    driven: Array,
    signs: Array | None = None,
    gap_rate: Array | None = None,
    rotor: Array | float = 0.0,
) -> Motion:
    """Return the motion of links with pose and rates (n, 3); joints as in explicit.evaluate.

    `gap_rate` (n-1, 2) is what the dampers act on, if not the present rates of the gaps.
    """
    n, normal = p.links, axes(pose[:, 2])[1]
    ground = explicit.friction(p, pose[:, 2], rates[:, :2], signs)
    force = joint_forces(p, spring, pose, rates, gap_rate)
    load = np.zeros((n, 3), dtype=force.dtype)
    load[:, :2] = ground + p.mass_kg * np.asarray(p.gravity_m_s2)
    for i in range(n - 1):
        load[i, :2] += force[i]
        load[i + 1, :2] -= force[i]
        load[i, 2] += p.half_length_m * normal[i] @ force[i]
        load[i + 1, 2] += p.half_length_m * normal[i + 1] @ force[i]
    angles = angle_rows(n)
    free_torque = np.where(driven, 0.0, torque)
    rows = angles[driven]
    mass = np.diag(np.tile([p.mass_kg, p.mass_kg, p.inertia], n))
    rotors = np.where(driven, 0.0, rotor)
    mass = mass + angles.T @ np.diag(rotors) @ angles  # their energy is rotor phi'^2 / 2
    matrix = np.block([[mass, rows.T], [rows, np.zeros((len(rows), len(rows)))]])
    right = np.concatenate([load.ravel() - angles.T @ free_torque, phi_ddot[driven]])
    solution = np.linalg.solve(matrix, right)
    accel = solution[: 3 * n].reshape(n, 3)
    joint_torque = free_torque.astype(solution.dtype)
    joint_torque += rotors * np.diff(accel[:, 2])
    joint_torque[driven] = solution[3 * n :]
    return Motion(rates[:, :2], ground, accel[:, :2], accel[:, 2], force, joint_torque)


def torque_driven(p: Params, spring: Spring, pose: Array, rates: Array, torque: Array) -> Motion:
    """Return the motion under given joint torques (n-1,), N m; pose, rates (n, 3)."""
    none = np.zeros(p.links - 1)
    limp = none.astype(bool)
    return evaluate(p, spring, pose, rates, torque=np.asarray(torque), phi_ddot=none, driven=limp)


def angle_driven(p: Params, spring: Spring, pose: Array, rates: Array, phi_ddot: Array) -> Motion:
    """Return the motion under imposed phi'' (n-1,); pose, rates (n, 3) agree with phi, phi'."""
    none, driven = np.zeros(p.links - 1), np.ones(p.links - 1, bool)
    return evaluate(
        p, spring, pose, rates, torque=none, phi_ddot=np.asarray(phi_ddot), driven=driven
    )


def closed_links(p: Params, q: Array, qdot: Array) -> tuple[Array, Array]:
    """Return pose and rates (n, 3) of links whose joints are closed; q, qdot (n+2,)."""
    pose = np.column_stack([explicit.centres(p, q), q[2:]])
    return pose, np.column_stack([explicit.centre_velocities(p, q, qdot), qdot[2:]])


def gait_rate(p: Params, spring: Spring, gait: Gait) -> Callable[[float, Array], Array]:
    """Return y' = f(t, y) of the angle-driven model; y = (x_i, y_i.., theta_1, and their rates)."""

    def rate(t_s: float, y: Array) -> Array:
        pose, rates, phi_ddot = unpack(p, gait, t_s, y)
        motion = angle_driven(p, spring, pose, rates, phi_ddot)
        half = 2 * p.links + 1
        return np.concatenate([y[half:], motion.accel_m_s2.ravel(), motion.theta_ddot[:1]])

    return rate


def unpack(p: Params, gait: Gait, t_s: float, y: Array) -> tuple[Array, Array, Array]:
    """Return pose and rates (n, 3) and phi'' from the angle-driven state y (4n + 2,)."""
    n = p.links
    phi, phi_dot, phi_ddot = gait.angles(t_s, n - 1)
    turn = np.concatenate([[0.0], np.cumsum(phi)])
    turn_rate = np.concatenate([[0.0], np.cumsum(phi_dot)])
    place, speed = y[: 2 * n + 1], y[2 * n + 1 :]
    pose = np.column_stack([place[:-1].reshape(n, 2), place[-1] + turn])
    return pose, np.column_stack([speed[:-1].reshape(n, 2), speed[-1] + turn_rate]), phi_ddot


def pack(pose: Array, rates: Array) -> Array:
    """Return the angle-driven state (4n + 2,) of pose and rates (n, 3)."""
    return np.concatenate([pose[:, :2].ravel(), pose[:1, 2], rates[:, :2].ravel(), rates[:1, 2]])


def integrate(
    rate: Callable[[float, Array], Array],
    y: Array,
    t_s: Array,
    method: str = "DOP853",
    rtol: float = 1e-12,
) -> Array:
    """Return the states at the times t_s from y at t = 0, by DOP853 or (stiff) Radau."""
    span = (0.0, float(t_s[-1]))
    result = solve_ivp(rate, span, y, method, t_s, rtol=rtol, atol=rtol / 100)
    if not result.success:
        raise RuntimeError(result.message)
    return result.y.T
