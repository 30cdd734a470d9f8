"""The angle-driven exact model in the frame of link 1: three velocities, by d'Alembert's principle.

u = (v_x, v_y, w) are the velocity and spin of link 1 in its own frame. Link i sits there at r_i(t),
turned by psi_i(t), both known from the gait. In the turning frame its acceleration is

    a_i = u' + w z x u + w' z x r_i + 2 w z x r_i' - w**2 r_i + r_i'',

and the three unknowns u' follow from the balance of force and of moment about link 1 of the whole
snake. Heading does not enter: on flat ground the motion is periodic in u alone.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .explicit import axes
from .params import Array, Gait, Params


@dataclass(frozen=True)
class Shape:
    """Hold where the links are in link 1's frame at one time."""

    psi: tuple[Array, Array, Array]  # (n,) angle, rate, second rate
    place: tuple[Array, Array, Array]  # (n, 2) r_i, r_i', r_i''
    tangent: Array  # (n, 2)
    normal: Array  # (n, 2)
    phi_dot: Array  # (n-1,)


def across(vectors: Array) -> Array:
    """Return z x v of plane vectors (..., 2)."""
    return np.stack([-vectors[..., 1], vectors[..., 0]], -1)


def cross(a: Array, b: Array) -> Array:
    """Return a_x b_y - a_y b_x of plane vectors (..., 2)."""
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def shape_at(p: Params, gait: Gait, t_s: float) -> Shape:
    """Return the shape the gait imposes at a time."""
    if any(p.gravity_m_s2):
        raise ValueError("the body frame has no heading, so it cannot hold an incline")
    joints = gait.angles(t_s, p.links - 1)
    psi, rate, second = (np.concatenate([[0.0], np.cumsum(part)]) for part in joints)
    tangent, normal = axes(psi)
    arms = (
        tangent,
        normal * rate[:, None],
        normal * second[:, None] - tangent * rate[:, None] ** 2,
    )
    start = np.zeros((1, 2))
    place = tuple(
        p.half_length_m * np.cumsum(np.concatenate([start, arm[:-1] + arm[1:]]), axis=0)
        for arm in arms
    )
    return Shape((psi, rate, second), place, tangent, normal, joints[1])


def link_velocities(shape: Shape, u: Array) -> Array:
    """Return the link centres' velocities (n, 2) in link 1's frame."""
    return u[:2] + u[2] * across(shape.place[0]) + shape.place[1]


def slip(shape: Shape, u: Array) -> Array:
    """Return tangential and normal contact velocities of the links, (n, 2)."""
    velocity = link_velocities(shape, u)
    along, over = (np.sum(velocity * axis, -1) for axis in (shape.tangent, shape.normal))
    return np.stack([along, over], -1)


def contact_forces(shape: Shape, local: Array) -> Array:
    """Return forces (n, 2) in link 1's frame from tangential and normal ones (n, 2)."""
    return local[:, :1] * shape.tangent + local[:, 1:] * shape.normal


def known_accelerations(shape: Shape, u: Array) -> Array:
    """Return the part of the link accelerations (n, 2) that does not depend on u'."""
    place, rate, second = shape.place
    centripetal = u[2] * across(u[:2]) - u[2] ** 2 * place
    return centripetal + 2 * u[2] * across(rate) + second


def mass_matrix(p: Params, shape: Shape) -> Array:
    """Return the (3, 3) inertia of the momentarily rigid snake about link 1."""
    total, moment = p.links * p.mass_kg, p.mass_kg * shape.place[0].sum(0)
    spin = p.links * p.inertia + p.mass_kg * np.sum(shape.place[0] ** 2)
    (first, second) = moment
    return np.array([[total, 0, -second], [0, total, first], [-second, first, spin]])


def resultant(shape: Shape, forces: Array) -> Array:
    """Return (sum f_x, sum f_y, sum r x f) of forces (n, 2) at the link centres."""
    return np.append(forces.sum(0), cross(shape.place[0], forces).sum())


def u_dot(p: Params, shape: Shape, u: Array, ground: Array) -> Array:
    """Return u' under ground forces (n, 2), all in link 1's frame."""
    load = resultant(shape, ground - p.mass_kg * known_accelerations(shape, u))
    load[2] -= p.inertia * shape.psi[2].sum()
    return np.linalg.solve(mass_matrix(p, shape), load)


def viscous(p: Params, shape: Shape, u: Array) -> Array:
    """Return the viscous ground forces (n, 2) in link 1's frame."""
    return contact_forces(shape, -slip(shape, u) * np.array([p.ct, p.cn]))


def joint_torques(p: Params, shape: Shape, u: Array, rate: Array, ground: Array) -> Array:
    """Return T_i (n-1,) on link i from link i+1: the moment, about joint i, of the links behind it.

    T_i = sum_{j<=i} [I theta_j'' + (r_j - joint_i) x (m a_j - f_j)].
    """
    accel = known_accelerations(shape, u) + rate[:2] + rate[2] * across(shape.place[0])
    effective = p.mass_kg * accel - ground
    spin = p.inertia * (rate[2] + shape.psi[2])
    joints = shape.place[0][:-1] + p.half_length_m * shape.tangent[:-1]
    return np.array(
        [
            np.sum(spin[: i + 1] + cross(shape.place[0][: i + 1] - joints[i], effective[: i + 1]))
            for i in range(p.links - 1)
        ]
    )
