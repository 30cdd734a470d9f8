"""One evaluation of either formulation: accelerations, friction, joint forces and torques."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from ..simulation.methods import FORMULATIONS
from .errors import BadInput, check_choice, check_number
from .robot import Gait, Ground, Robot, core_model

Array = NDArray[np.float64]


def finite_vector(name: str, values: ArrayLike, size: int) -> Array:
    """Return values as `size` finite floats, or raise BadInput naming what is wrong."""
    try:
        vector = np.asarray(values, dtype=float)
    except (TypeError, ValueError):
        raise BadInput(f"{name} is {values!r}; it must be {size} numbers") from None
    if vector.shape != (size,):
        raise BadInput(f"{name} has shape {vector.shape}; it must be {size} numbers")
    if not math.isfinite(vector.sum()) and not np.isfinite(vector).all():
        where = int(np.flatnonzero(~np.isfinite(vector))[0])
        raise BadInput(f"{name}[{where}] is {vector[where]}; it must be a finite number")
    return np.ascontiguousarray(vector)


@dataclass(frozen=True, slots=True)
class LinkState:
    """Hold where every link is and how it moves: six arrays (n,), ground frame, from the tail.

    x_m, y_m: centres; theta_rad: absolute angles; vx_m_s, vy_m_s, omega_rad_s: their rates.
    """

    x_m: Array
    y_m: Array
    theta_rad: Array
    vx_m_s: Array
    vy_m_s: Array
    omega_rad_s: Array

    def __post_init__(self) -> None:
        n = np.size(self.theta_rad)
        for name in self.__slots__:
            object.__setattr__(self, name, finite_vector(name, getattr(self, name), n))

    @property
    def links(self) -> int:
        """Return the number of links n."""
        return self.theta_rad.size

    @classmethod
    def row(cls, arrays: Any, index: int) -> LinkState:
        """Take one row of the six arrays of the same names that a result holds."""
        return cls(*(getattr(arrays, name)[index] for name in cls.__slots__))

    @classmethod
    def joined(cls, robot: Robot, q: ArrayLike, qdot: ArrayLike) -> LinkState:
        """Place all links from q = (x, y, theta_1..theta_n) of Eqs. 10-21 and its rates.

        x, y are the centre of link 1 (the tail); the joints are closed, as the explicit model
        wants.
        """
        n = robot.links
        p, v = finite_vector("q", q, n + 2), finite_vector("qdot", qdot, n + 2)
        theta, omega = p[2:], v[2:]
        c, s = np.cos(theta), np.sin(theta)
        arms = robot.link_length_m / 2 * np.stack([c, s, -s * omega, c * omega])  # to the joint
        places = np.empty((4, n))
        places[:, 0] = p[0], p[1], v[0], v[1]
        places[:, 1:] = arms[:, :-1] + arms[:, 1:]
        x, y, vx, vy = places.cumsum(axis=1)
        return cls(x, y, theta, vx, vy, omega)

    @classmethod
    def in_gait(
        cls, robot: Robot, gait: Gait, t_s: float, tail: ArrayLike, tail_rate: ArrayLike
    ) -> LinkState:
        """Place all links from link 1, (x, y, theta_1) and its rates, and the gait at time t_s."""
        n = robot.links
        phase = gait.omega_rad_s * t_s + gait.beta_rad * np.arange(n - 1)
        phi = gait.offset_rad + gait.alpha_rad * np.sin(phase)
        rate = gait.omega_rad_s * gait.alpha_rad * np.cos(phase)
        p, v = finite_vector("tail", tail, 3), finite_vector("tail_rate", tail_rate, 3)
        theta = p[2] + np.concatenate(([0.0], np.cumsum(phi)))
        omega = v[2] + np.concatenate(([0.0], np.cumsum(rate)))
        return cls.joined(robot, [*p[:2], *theta], [*v[:2], *omega])

    def packed(self) -> Array:
        """Return the six arrays one behind the other, (6 n,)."""
        return np.concatenate([getattr(self, name) for name in self.__slots__])


@dataclass(frozen=True, slots=True)
class TorqueDrive:
    """Impose joint torques T_i on link i from link i+1, (n-1,), N m; Eqs. 3, 6, 9."""

    torque_nm: Array


@dataclass(frozen=True, slots=True)
class AngleDrive:
    """Impose the second derivatives phi_i'' of the joint angles, (n-1,), rad/s^2."""

    bend_rad_s2: Array

    @classmethod
    def of(cls, robot: Robot, gait: Gait, t_s: float) -> AngleDrive:
        """Take them from a gait at time t_s (Eq. 57)."""
        phase = gait.omega_rad_s * t_s + gait.beta_rad * np.arange(robot.links - 1)
        return cls(-(gait.omega_rad_s**2) * gait.alpha_rad * np.sin(phase))


@dataclass(frozen=True, slots=True)
class Acceleration:
    """Hold what one evaluation gives; arrays over links (n,) or joints (n-1,), ground frame.

    ax_m_s2, ay_m_s2, alpha_rad_s2: accelerations of the centres and angles. friction_x_n,
    friction_y_n: force of the ground on each link. joint_force_x_n, joint_force_y_n,
    joint_torque_nm: on link i from link i+1.
    """

    ax_m_s2: Array
    ay_m_s2: Array
    alpha_rad_s2: Array
    friction_x_n: Array
    friction_y_n: Array
    joint_force_x_n: Array
    joint_force_y_n: Array
    joint_torque_nm: Array

    @property
    def qddot(self) -> Array:
        """Return (x'', y'' of link 1, theta_1''..theta_n''), (n+2,)."""
        return np.concatenate((self.ax_m_s2[:1], self.ay_m_s2[:1], self.alpha_rad_s2))


def acceleration(
    robot: Robot,
    ground: Ground,
    state: LinkState | tuple[ArrayLike, ArrayLike],
    *,
    drive: TorqueDrive | AngleDrive,
    formulation: str = "explicit",
    joint_stiffness_n_m: float = 1e3,
    joint_damping_n_s_m: float = 1.0,
    smoothing_m_s: float = 0.0,
) -> Acceleration:
    """Evaluate a formulation once: Eqs. 1-9 with pinned joints (explicit) or Eqs. 51-56 (implicit).

    state: a LinkState, or (q, qdot) as LinkState.joined takes them; the explicit model uses only
    link 1's position and velocity and all angles and rates. drive: TorqueDrive or AngleDrive. Dry
    friction is taken with sgn 0 = 0, or as v / sqrt(v^2 + w^2) with w = smoothing_m_s > 0. Raises
    BadInput.
    """
    check_choice("formulation", formulation, FORMULATIONS)
    if not isinstance(state, LinkState):
        state = LinkState.joined(robot, *state)
    if state.links != robot.links:
        raise BadInput(f"state has {state.links} links, the robot has {robot.links}")
    torque = isinstance(drive, TorqueDrive)
    name, values = ("torque_nm", drive.torque_nm) if torque else ("bend_rad_s2", drive.bend_rad_s2)
    request = _core.RunRequest(core_model(robot, ground, Gait(0.0, 0.0, 1.0)))
    request.formulation = getattr(_core.Formulation, formulation)
    request.drive = _core.Drive.torque if torque else _core.Drive.angle
    request.set_spring(
        check_number("joint_stiffness_n_m", joint_stiffness_n_m, 0.0),
        check_number("joint_damping_n_s_m", joint_damping_n_s_m, 0.0),
    )
    request.smoothing_m_s = check_number("smoothing_m_s", smoothing_m_s, 0.0)
    out: dict[str, Any] = _core.evaluate(
        request, state.packed(), finite_vector(name, values, robot.links - 1)
    )
    names = ("ax", "ay", "alpha", "fx", "fy", "joint_fx", "joint_fy", "joint_torque")
    return Acceleration(*(out[n] for n in names))
