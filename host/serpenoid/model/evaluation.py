"""One evaluation of either formulation: accelerations, friction, joint forces and torques."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from .. import _core
from ..base.checks import check_choice, check_number
from ..base.errors import BadInput
from ..base.vectors import Array, finite_vector
from .core_model import check_parts, core_model
from .gait import Gait
from .ground import Ground
from .link_state import LinkState
from .robot import Robot


@dataclass(frozen=True, slots=True)
class Acceleration:
    """Hold what one evaluation of a model gives, in the ground's frame, from the tail.

    Attributes
    ----------
    ax_m_s2, ay_m_s2 : (n,)
        Accelerations of the links' centres, m/s^2.
    alpha_rad_s2 : (n,)
        Angular accelerations, rad/s^2.
    friction_x_n, friction_y_n : (n,)
        Force of the ground on each link, N.
    joint_force_x_n, joint_force_y_n, joint_torque_nm : (n-1,)
        On link i from link i+1, N and N m.

    Examples
    --------
    >>> robot = sn.Robot(links=3, link_mass_kg=1.0, link_length_m=0.12)
    >>> ground = sn.Ground(ct=0.1, cn=10.0)
    >>> q, qdot = [0.1, -0.2, 0.3, -0.4, 0.7], [0.05, -0.03, 1.1, -0.7, 0.4]
    >>> motion = sn.acceleration(robot, ground, (q, qdot), torque_nm=[0.02, -0.01])
    >>> motion.joint_force_x_n.round(4).tolist()
    [0.4285, 0.3458]
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
        """Return qddot: x'', y'' of link 1, m/s^2, theta_1''..theta_n'', rad/s^2, (n+2,)."""
        return np.concatenate((self.ax_m_s2[:1], self.ay_m_s2[:1], self.alpha_rad_s2))


def acceleration(
    robot: Robot,
    ground: Ground,
    state: LinkState | tuple[ArrayLike, ArrayLike],
    *,
    torque_nm: ArrayLike | None = None,
    joint_acceleration_rad_s2: ArrayLike | None = None,
    formulation: str = "explicit",
    joint_stiffness_n_m: float = 1e3,
    joint_damping_n_s_m: float = 1.0,
) -> Acceleration:
    """Evaluate a formulation once: Eqs. 1-9 with pinned joints (explicit) or Eqs. 51-56 (implicit).

    Parameters
    ----------
    robot
        What moves.
    ground
        Friction of what it moves on. Dry friction at rest is 0 here (sgn 0 = 0).
    state
        A LinkState, or (q, qdot) as `LinkState.joined` takes them. The explicit model reads the
        position and velocity of link 1 only, and all angles and rates.
    torque_nm : (n-1,)
        T_i on link i from link i+1, N m (Eqs. 3, 6, 9).
    joint_acceleration_rad_s2 : (n-1,)
        phi_i'', rad/s^2, in place of torques.
    formulation
        "explicit" or "implicit".
    joint_stiffness_n_m
        Stiffness of the springs in the joints, N/m.
    joint_damping_n_s_m
        Damping in the joints, N s/m.

    Returns
    -------
    Acceleration
        Accelerations and joint forces, torques or rates.

    Raises
    ------
    BadInput
        For arguments of a wrong kind or out of range, and unless either torques or accelerations
        of the joints are given.

    Examples
    --------
    >>> robot = sn.Robot(links=3, link_mass_kg=1.0, link_length_m=0.12)
    >>> ground = sn.Ground(ct=0.1, cn=10.0)
    >>> q, qdot = [0.1, -0.2, 0.3, -0.4, 0.7], [0.05, -0.03, 1.1, -0.7, 0.4]
    >>> motion = sn.acceleration(robot, ground, (q, qdot), torque_nm=[0.02, -0.01])
    >>> motion.qddot.round(4).tolist()
    [0.2964, 0.3223, 5.9634, -7.6883, 2.5509]
    """
    check_parts(robot, ground)
    check_choice("formulation", formulation)
    if not isinstance(state, LinkState):
        try:
            q, qdot = state
        except (TypeError, ValueError):
            kind = type(state).__name__
            raise BadInput(f"state is a {kind}; give a LinkState or (q, qdot)") from None
        state = LinkState.joined(robot, q, qdot)
    if state.links != robot.links:
        raise BadInput(f"state has {state.links} links, the robot has {robot.links}")
    request = _core.RunRequest(core_model(robot, ground, Gait(0.0, 0.0, 1.0)))
    request.choose(formulation, "angle" if torque_nm is None else "torque", "rk4")
    joints = {"torque_nm": torque_nm, "joint_acceleration_rad_s2": joint_acceleration_rad_s2}
    imposed = [(name, values) for name, values in joints.items() if values is not None]
    if len(imposed) != 1:
        raise BadInput(f"{len(imposed)} of {' and '.join(joints)} are given; give one of them")
    request.joint_stiffness_n_m = check_number("joint_stiffness_n_m", joint_stiffness_n_m, 0.0)
    request.joint_damping_n_s_m = check_number("joint_damping_n_s_m", joint_damping_n_s_m, 0.0)
    by_joint = finite_vector(*imposed[0], robot.links - 1)
    values = _core.evaluate(request, state.packed(), by_joint)
    names = "ax", "ay", "alpha", "fx", "fy", "joint_fx", "joint_fy", "joint_torque"
    return Acceleration(*(values[name] for name in names))
