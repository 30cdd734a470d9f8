"""Where every link is and how it moves, all at one time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..base.vectors import Array, finite_vector
from .gait import Gait, joint_motion
from .robot import Robot


@dataclass(frozen=True, slots=True)
class LinkState:
    """Hold where every link is and how it moves, in the ground's frame, from the tail.

    Attributes
    ----------
    x_m, y_m : (n,)
        Links' centres, m.
    theta_rad : (n,)
        Absolute angles, rad.
    vx_m_s, vy_m_s, omega_rad_s : (n,)
        Their rates, m/s and rad/s.

    Examples
    --------
    >>> rest = [0.0, 0.0, 0.0]
    >>> state = sn.LinkState([0.0, 0.12, 0.24], rest, rest, rest, rest, rest)
    >>> state.x_m.shape
    (3,)
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

        q: x, y, the centre of link 1 (the tail), in m, angles in rad; qdot: in m/s, rad/s. The
        joints are closed, as the explicit model wants.
        """
        n = robot.links
        p, v = finite_vector("q", q, n + 2), finite_vector("qdot", qdot, n + 2)
        theta, omega = p[2:], v[2:]
        c, s = np.cos(theta), np.sin(theta)
        arms = robot.link_length_m / 2 * np.stack([c, s, -s * omega, c * omega])  # a joint's
        places = np.empty((4, n))
        places[:, 0] = p[0], p[1], v[0], v[1]
        places[:, 1:] = arms[:, :-1] + arms[:, 1:]
        x, y, vx, vy = places.cumsum(axis=1)
        return cls(x, y, theta, vx, vy, omega)

    @classmethod
    def in_gait(
        cls, robot: Robot, gait: Gait, t_s: float, tail: ArrayLike, tail_rate: ArrayLike
    ) -> LinkState:
        """Place all links from link 1 and the gait at time t_s, in s.

        tail: (x, y, theta_1) of link 1 in m, m, rad; tail_rate: its rates in m/s, m/s, rad/s."""
        phi, rate, _ = joint_motion(gait, robot.links - 1, t_s)
        p, v = finite_vector("tail", tail, 3), finite_vector("tail_rate", tail_rate, 3)
        return cls.joined(robot, from_tail(p, phi), from_tail(v, rate))

    def packed(self) -> Array:
        """Return the six arrays one behind the other, (6 n,)."""
        return np.concatenate([getattr(self, name) for name in self.__slots__])


def from_tail(tail: Array, joints: Array) -> Array:
    """Return x, y and the links' angles from link 1's three numbers and the joints' angles.

    Or their rates, of rates.
    """
    return np.concatenate([tail[:2], tail[2] + np.append(0.0, joints.cumsum())])
