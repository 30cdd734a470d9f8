"""The exact model of any number of links as one dense constrained system, solved as it stands.

Every link is a free rigid body; X = (x_1, y_1, theta_1, ..., x_n, y_n, theta_n). Joint i closes the
gap g_i = (c_{i+1} - l t_{i+1}) - (c_i + l t_i) = 0, and an imposed joint angle is the further
constraint h_i = theta_{i+1} - theta_i - phi_i(t) = 0. F_i and T_i, the force and torque on link i
from link i+1, do the virtual work -F_i . dg_i - T_i dh_i, so they are the multipliers themselves:

    [M  A^T] [X'']   [external forces - (imposed torques)]
    [A   0 ] [F,T] = [-(dA/dt) X', phi'']

Nothing is eliminated and no structure is used; that is the point of it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

from .params import Array, Gait, Params


@dataclass(frozen=True)
class Motion:
    """Hold one evaluation: accelerations and forces, global frame, links counted from the tail."""

    velocity_m_s: Array  # (n, 2) of the link centres
    friction_n: Array  # (n, 2) ground friction on each link
    accel_m_s2: Array  # (n, 2) of the link centres
    theta_ddot: Array  # (n,)
    force_n: Array  # (n-1, 2) F_i
    torque_n_m: Array  # (n-1,) T_i

    @property
    def qddot(self) -> Array:
        """Return (x'', y'' of link 1, theta_1'', ..., theta_n''), shape (n+2,)."""
        return np.concatenate([self.accel_m_s2[0], self.theta_ddot])


def axes(theta: Array) -> tuple[Array, Array]:
    """Return tangents and normals of the links, each (n, 2)."""
    cos, sin = np.cos(theta), np.sin(theta)
    return np.stack([cos, sin], -1), np.stack([-sin, cos], -1)


def centres(p: Params, q: Array) -> Array:
    """Return the link centres (n, 2) for q = (x, y, theta_1..theta_n) (Eqs. 10-15)."""
    arm = p.half_length_m * axes(q[2:])[0]
    steps = np.concatenate([[q[:2]], arm[:-1] + arm[1:]])
    return np.cumsum(steps, axis=0)


def centre_velocities(p: Params, q: Array, qdot: Array) -> Array:
    """Return the velocities of the link centres (n, 2) (Eqs. 16-21)."""
    arm = p.half_length_m * axes(q[2:])[1] * qdot[2:, None]
    return np.cumsum(np.concatenate([[qdot[:2]], arm[:-1] + arm[1:]]), axis=0)


def friction(p: Params, theta: Array, velocity: Array, signs: Array | None = None) -> Array:
    """Return the friction force on each link (n, 2), opposing motion: f = -(C v + F_0 sgn v).

    `signs` (n, 2), tangential then normal, replaces sgn v where the velocity is zero and the
    force therefore a choice within [-1, 1]. Along a link C and F_0 go over from those backwards to
    those forwards as the sign does.
    """
    tangent, normal = axes(theta)
    vt, vn = np.sum(velocity * tangent, -1), np.sum(velocity * normal, -1)
    if signs is None:
        signs = np.stack([np.sign(vt.real), np.sign(vn.real)], -1)
    ct, ft0 = (
        (ahead + back) / 2 + (ahead - back) / 2 * signs[:, 0]
        for ahead, back in zip((p.ct, p.ft0), p.backwards, strict=True)
    )
    ft = -(ct * vt + ft0 * signs[:, 0])
    fn = -(p.cn * vn + p.fn0 * signs[:, 1])
    return ft[:, None] * tangent + fn[:, None] * normal


def gap_rows(p: Params, theta: Array, theta_dot: Array) -> tuple[Array, Array]:
    """Return A (2(n-1), 3n) of the joint gaps, and (dA/dt) X' (2(n-1),)."""
    n, half = p.links, p.half_length_m
    tangent, normal = axes(theta)
    rows = np.zeros((2 * (n - 1), 3 * n), dtype=theta.dtype)
    drift = np.zeros(2 * (n - 1), dtype=np.result_type(theta, theta_dot))
    for i in range(n - 1):
        for axis in range(2):
            row = 2 * i + axis
            rows[row, 3 * i + axis], rows[row, 3 * i + 3 + axis] = -1.0, 1.0
            for link in (i, i + 1):
                rows[row, 3 * link + 2] = -half * normal[link, axis]
                drift[row] += half * tangent[link, axis] * theta_dot[link] ** 2
    return rows, drift


def angle_rows(links: int) -> Array:
    """Return the rows (n-1, 3n) of the joint angles theta_{i+1} - theta_i."""
    rows = np.zeros((links - 1, 3 * links))
    for i in range(links - 1):
        rows[i, 3 * i + 2], rows[i, 3 * i + 5] = -1.0, 1.0
    return rows


def evaluate(
    p: Params,
    q: Array,
    qdot: Array,
    *,
    torque: Array,
    phi_ddot: Array,
    driven: Array,
    signs: Array | None = None,
    rotor: Array | float = 0.0,
) -> Motion:
    """Return the motion where joint i has an imposed angle (driven[i]) or an imposed torque.

    q, qdot: (n+2,) of (x, y of link 1, theta_1..n); torque, phi_ddot, driven: (n-1,). A limp joint
    is an undriven one with zero torque, a locked joint a driven one with zero phi_ddot. rotor: a
    motor's inertia at the joints that are not driven, whose `torque` acts on the rotor. The rates
    in qdot must already agree with the imposed ones.
    """
    n, theta, theta_dot = p.links, q[2:], qdot[2:]
    velocity = centre_velocities(p, q, qdot)
    force = friction(p, theta, velocity, signs)
    gaps, drift = gap_rows(p, theta, theta_dot)
    angles = angle_rows(n)
    load = np.zeros((n, 3), dtype=force.dtype)
    load[:, :2] = force + p.mass_kg * np.asarray(p.gravity_m_s2)
    free_torque = np.where(driven, 0.0, torque)
    load = load.ravel() - angles.T @ free_torque
    rows = np.vstack([gaps, angles[driven]])
    mass = np.diag(np.tile([p.mass_kg, p.mass_kg, p.inertia], n))
    rotors = np.where(driven, 0.0, rotor)
    mass = mass + angles.T @ np.diag(rotors) @ angles  # their energy is rotor phi'^2 / 2
    matrix = np.block([[mass, rows.T], [rows, np.zeros((len(rows), len(rows)))]])
    solution = np.linalg.solve(matrix, np.concatenate([load, -drift, phi_ddot[driven]]))
    accel, multipliers = solution[: 3 * n].reshape(n, 3), solution[3 * n :]
    joint_torque = free_torque.astype(solution.dtype)
    joint_torque += rotors * np.diff(accel[:, 2])  # what is left for the links
    joint_torque[driven] = multipliers[2 * (n - 1) :]
    joint_force = multipliers[: 2 * (n - 1)].reshape(n - 1, 2)
    return Motion(velocity, force, accel[:, :2], accel[:, 2], joint_force, joint_torque)


def torque_driven(
    p: Params, q: Array, qdot: Array, torque: Array, signs: Array | None = None
) -> Motion:
    """Return the motion under given joint torques T_i (n-1,), N m; q, qdot (n+2,)."""
    none = np.zeros(p.links - 1)
    limp = none.astype(bool)
    torque = np.asarray(torque)
    return evaluate(p, q, qdot, torque=torque, phi_ddot=none, driven=limp, signs=signs)


def angle_driven(
    p: Params,
    pose: Array,
    rates: Array,
    joints: tuple[Array, Array, Array],
    signs: Array | None = None,
) -> Motion:
    """Return the motion under imposed joint angles.

    pose, rates: (3,) of link 1's (x, y, theta) and their rates; joints: (phi, phi', phi''), each
    (n-1,) in rad, rad/s, rad/s**2.
    """
    phi, phi_dot, phi_ddot = (np.asarray(part) for part in joints)
    q, qdot = whole_state(pose, phi), whole_state(rates, phi_dot)
    torque, driven = np.zeros_like(phi), np.ones(len(phi), bool)
    return evaluate(p, q, qdot, torque=torque, phi_ddot=phi_ddot, driven=driven, signs=signs)


def whole_state(link1: Array, joints: Array) -> Array:
    """Return (x, y, theta_1..n) from link 1's (x, y, theta) and the joint angles (or rates)."""
    return np.concatenate([link1[:2], link1[2] + np.concatenate([[0.0], np.cumsum(joints)])])


def trajectory(p: Params, gait: Gait, start: Array, t_s: Array, rtol: float = 1e-12) -> Array:
    """Return link 1's (x, y, theta, x', y', theta') at the times t_s, shape (len(t_s), 6).

    Angles imposed, started at t = 0 from `start` (6,); for smooth friction only.
    """

    def rate(t: float, y: Array) -> Array:
        motion = angle_driven(p, y[:3], y[3:], gait.angles(t, p.links - 1))
        return np.concatenate([y[3:], motion.accel_m_s2[0], motion.theta_ddot[:1]])

    span = (0.0, float(t_s[-1]))
    result = solve_ivp(rate, span, start, "DOP853", t_s, rtol=rtol, atol=rtol / 10)
    if not result.success:
        raise RuntimeError(result.message)
    return result.y.T
