"""The exact model of any number of links as one dense system, solved as it stands.

Every link is a free rigid body; X = (x_1, y_1, theta_1, ..., x_n, y_n, theta_n). Joint i opens by
g_i = (c_{i+1} - l t_{i+1}) - (c_i + l t_i), whose rate is A X'. F_i, the force on link i from link
i+1, does the virtual work -F_i . dg_i. Pinned joints keep g = 0, and F are the multipliers of that;
on springs (the paper's implicit model, Eqs. 51-56) F_i = k g_i + c g_i'. An imposed joint angle is
the further constraint theta_{i+1} - theta_i = phi_i(t), whose multiplier is T_i:

    [M  B^T] [X'']   [external forces - (given F, T)]
    [B   0 ] [F,T] = [-(dA/dt) X', phi'']             B: the rows of A and of the angles that hold

Nothing is eliminated and no structure is used; that is the point of it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .params import Array, Params


@dataclass(frozen=True)
class Motion:
    """Hold one evaluation: accelerations and forces, global frame, links counted from the tail."""

    friction_n: Array  # (n, 2) ground friction on each link
    accel_m_s2: Array  # (n, 2) of the link centres
    theta_ddot: Array  # (n,)
    force_n: Array  # (n-1, 2) F_i
    torque_n_m: Array  # (n-1,) T_i


@dataclass(frozen=True)
class Spring:
    """Hold the joints' stiffness and damping."""

    stiffness_n_m: float = 1000.0
    damping_n_s_m: float = 1.0


def axes(theta: Array) -> tuple[Array, Array]:
    """Return tangents and normals of the links, each (n, 2)."""
    cos, sin = np.cos(theta), np.sin(theta)
    return np.stack([cos, sin], -1), np.stack([-sin, cos], -1)


def closed_links(p: Params, q: Array, qdot: Array) -> tuple[Array, Array]:
    """Return pose and rates (n, 3) of links with closed joints from (x, y, theta_1..n), (n+2,)."""
    tangent, normal = axes(q[2:])
    arm, arm_rate = p.half_length_m * tangent, p.half_length_m * normal * qdot[2:, None]
    centres = np.cumsum([q[:2], *(arm[:-1] + arm[1:])], axis=0)  # Eqs. 10-15
    speeds = np.cumsum([qdot[:2], *(arm_rate[:-1] + arm_rate[1:])], axis=0)  # Eqs. 16-21
    return np.column_stack([centres, q[2:]]), np.column_stack([speeds, qdot[2:]])


def friction(p: Params, theta: Array, velocity: Array) -> Array:
    """Return the friction force on each link (n, 2), opposing motion: f = -(C v + F_0 sgn v).

    Along a link C and F_0 forwards differ from those backwards on ratchet wheels.
    """
    tangent, normal = axes(theta)
    vt, vn = np.sum(velocity * tangent, -1), np.sum(velocity * normal, -1)
    signs = np.stack([np.sign(vt), np.sign(vn)], -1)
    ct, ft0 = (
        (ahead + back) / 2 + (ahead - back) / 2 * signs[:, 0]
        for ahead, back in zip((p.ct, p.ft0), p.backwards, strict=True)
    )
    ft = -(ct * vt + ft0 * signs[:, 0])
    fn = -(p.cn * vn + p.fn0 * signs[:, 1])
    return ft[:, None] * tangent + fn[:, None] * normal


def gap_rows(p: Params, pose: Array, rates: Array) -> tuple[Array, Array]:
    """Return A (2(n-1), 3n) of the joint gaps, and (dA/dt) X' (2(n-1),)."""
    n, half = p.links, p.half_length_m
    tangent, normal = axes(pose[:, 2])
    rows, drift = np.zeros((2 * (n - 1), 3 * n)), np.zeros(2 * (n - 1))
    for i in range(n - 1):
        for axis in range(2):
            row = 2 * i + axis
            rows[row, 3 * i + axis], rows[row, 3 * i + 3 + axis] = -1.0, 1.0
            for link in (i, i + 1):
                rows[row, 3 * link + 2] = -half * normal[link, axis]
                drift[row] += half * tangent[link, axis] * rates[link, 2] ** 2
    return rows, drift


def joint_gaps(p: Params, pose: Array, rates: Array) -> tuple[Array, Array]:
    """Return the gaps and their rates (n-1, 2) of links with pose and rates (n, 3) (Eqs. 53-56)."""
    arm = p.half_length_m * axes(pose[:, 2])[0]
    gap = (pose[1:, :2] - arm[1:]) - (pose[:-1, :2] + arm[:-1])
    return gap, (gap_rows(p, pose, rates)[0] @ rates.ravel()).reshape(-1, 2)


def evaluate(
    p: Params,
    pose: Array,
    rates: Array,
    *,
    torque: Array | None = None,
    phi_ddot: Array | None = None,
    driven: Array | None = None,
    spring: Spring | None = None,
    gap_rate: Array | None = None,
    rotor: Array | float = 0.0,
) -> Motion:
    """Return the motion of links with pose and rates (n, 3), joints pinned or on springs.

    Joint i has an imposed angle (driven[i], its second rate in phi_ddot) or a torque; all have
    torques, or all angles, where only one of the two is given. A limp joint is an undriven one with
    zero torque, a locked joint a driven one with zero phi_ddot. rotor: a motor's inertia at the
    joints that are not driven, whose `torque` acts on the rotor. gap_rate (n-1, 2): what dampers
    act on, if not the present rates of the gaps. The rates must agree with the imposed ones.
    """
    n = p.links
    driven = np.full(n - 1, torque is None) if driven is None else driven
    torque = np.zeros(n - 1) if torque is None else np.where(driven, 0.0, torque)
    ground = friction(p, pose[:, 2], rates[:, :2])
    load = np.zeros((n, 3))
    load[:, :2] = ground + p.mass_kg * np.asarray(p.gravity_m_s2)
    gaps, drift = gap_rows(p, pose, rates)
    angles = np.zeros((n - 1, 3 * n))  # rows of theta_{i+1} - theta_i
    for i in range(n - 1):
        angles[i, 3 * i + 2], angles[i, 3 * i + 5] = -1.0, 1.0
    force, rows, right = np.zeros((n - 1, 2)), gaps, -drift
    if spring is not None:
        gap, live = joint_gaps(p, pose, rates)
        damped = live if gap_rate is None else gap_rate
        force = spring.stiffness_n_m * gap + spring.damping_n_s_m * damped
        rows, right = gaps[:0], drift[:0]
    second = np.zeros(n - 1) if phi_ddot is None else np.asarray(phi_ddot)
    held, rotors = np.vstack([rows, angles[driven]]), np.where(driven, 0.0, rotor)
    mass = np.diag(np.tile([p.mass_kg, p.mass_kg, p.inertia], n))
    mass = mass + angles.T @ np.diag(rotors) @ angles  # their energy is rotor phi'^2 / 2
    matrix = np.block([[mass, held.T], [held, np.zeros((len(held), len(held)))]])
    pushes = load.ravel() - gaps.T @ force.ravel() - angles.T @ torque
    solution = np.linalg.solve(matrix, np.concatenate([pushes, right, second[driven]]))
    accel, multipliers = solution[: 3 * n].reshape(n, 3), solution[3 * n :]
    torque = torque + rotors * np.diff(accel[:, 2])  # what is left for the links
    torque[driven] = multipliers[len(rows) :]
    if spring is None:
        force = multipliers[: len(rows)].reshape(n - 1, 2)
    return Motion(ground, accel[:, :2], accel[:, 2], force, torque)
