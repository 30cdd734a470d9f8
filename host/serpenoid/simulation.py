"""Runs in time: start states, one call of the core, and a Run with everything it recorded."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from . import _core
from .dynamics import LinkState, finite_vector
from .errors import Diverged
from .model import core_model
from .scene import Scene
from .stability import check_step
from .steady import steady_gait

Array = NDArray[np.float64]
_FORWARD = np.array([-25.0, 48.0, -36.0, 16.0, -3.0]) / 12.0  # derivative from five points, order 4


@dataclass(frozen=True, slots=True)
class Run:
    """Hold a run: T recorded times t_s (T,), and (T, n) arrays over links counted from the tail.

    x_m, y_m: link centres, theta_rad: angles, vx_m_s, vy_m_s, omega_rad_s: their rates, ground
    frame. joint_force_x_n, joint_force_y_n, joint_torque_nm: (T, n-1), on link i from link i+1,
    only if "joints" was recorded (else empty).
    """

    scene: Scene
    t_s: Array
    x_m: Array
    y_m: Array
    theta_rad: Array
    vx_m_s: Array
    vy_m_s: Array
    omega_rad_s: Array
    joint_force_x_n: Array
    joint_force_y_n: Array
    joint_torque_nm: Array

    def state(self, index: int = -1) -> LinkState:
        """Return the state of all links at one recorded time."""
        names = ("x_m", "y_m", "theta_rad", "vx_m_s", "vy_m_s", "omega_rad_s")
        return LinkState(*(getattr(self, name)[index] for name in names))


def _torque_function(scene: Scene) -> Callable[[float], Array] | None:
    torque, joints = scene.torque, scene.robot.links - 1
    if torque is None:
        return None
    if callable(torque):
        return lambda t: finite_vector(f"torque at {t:g} s", torque(t), joints)
    constant = finite_vector("torque", torque, joints)
    return lambda _t: constant


def _zero_momentum(scene: Scene) -> LinkState:
    """Return the start in which neither the centre of mass moves nor the whole chain turns."""
    robot = scene.robot
    at_rest = LinkState.in_gait(robot, scene.gait, 0.0, [0, 0, 0], [0, 0, 0])
    m, inertia = robot.link_mass_kg, robot.inertia_kg_m2
    x, y = at_rest.x_m - at_rest.x_m.mean(), at_rest.y_m - at_rest.y_m.mean()
    vx, vy = at_rest.vx_m_s - at_rest.vx_m_s.mean(), at_rest.vy_m_s - at_rest.vy_m_s.mean()
    momentum = m * (x @ vy - y @ vx) + inertia * at_rest.omega_rad_s.sum()
    turn = -momentum / (robot.links * inertia + m * (x @ x + y @ y))
    shift_x, shift_y = -at_rest.vx_m_s.mean() - turn * y[0], -at_rest.vy_m_s.mean() + turn * x[0]
    return LinkState.in_gait(robot, scene.gait, 0.0, [0, 0, 0], [shift_x, shift_y, turn])


def _steady_start(scene: Scene) -> LinkState:
    """Return the explicit model's periodic state, link 1 at the origin heading along x."""
    robot, gait = scene.robot, scene.gait
    u = steady_gait(robot, scene.ground, gait, powers=False).body_velocity
    at_rest = LinkState.in_gait(robot, gait, 0.0, [0, 0, 0], [0, 0, 0])
    # link 1 moves as the centre of mass does, turned about it, less what the shape adds
    dx, dy = at_rest.x_m[0] - at_rest.x_m.mean(), at_rest.y_m[0] - at_rest.y_m.mean()
    vx = u[0] - u[2] * dy - at_rest.vx_m_s.mean()
    vy = u[1] + u[2] * dx - at_rest.vy_m_s.mean()
    return LinkState.in_gait(robot, gait, 0.0, [0, 0, 0], [vx, vy, u[2]])


def _explicit_start(scene: Scene) -> LinkState:
    if isinstance(scene.start, LinkState):
        return scene.start
    if scene.start == "zero_momentum":
        return _zero_momentum(scene)
    if scene.start == "steady":
        return _steady_start(scene)
    return LinkState.in_gait(scene.robot, scene.gait, 0.0, [0, 0, 0], [0, 0, 0])


def _on_slow_manifold(scene: Scene, start: LinkState) -> LinkState:
    """Open the joints by what their springs need to carry the explicit model's forces.

    Gap (F - c F'/k)/k and gap rate F'/k: the motion then has no ringing part to order 1/k^2. The
    centre of mass stays where it is. F' comes from five evaluations along the explicit motion.
    """
    h = 1e-3 / scene.gait.omega_rad_s
    exact = replace(
        scene, formulation="explicit", method="rk4", start=start, dt_s=h, duration_s=4 * h,
        record=("joints",), record_every=1,
    )  # fmt: skip
    run = simulate(exact)
    force = np.stack([run.joint_force_x_n, run.joint_force_y_n], axis=2)  # (5, n-1, 2)
    rate = np.tensordot(_FORWARD, force, axes=1) / h
    k, c = scene.joint_stiffness_n_m, scene.joint_damping_n_s_m
    gap, gap_rate = (force[0] - c * rate / k) / k, rate / k

    def opened(values: Array, gaps: Array) -> Array:
        shift = np.concatenate(([0.0], np.cumsum(gaps)))
        return values + shift - shift.mean()

    return LinkState(
        opened(start.x_m, gap[:, 0]), opened(start.y_m, gap[:, 1]), start.theta_rad,
        opened(start.vx_m_s, gap_rate[:, 0]), opened(start.vy_m_s, gap_rate[:, 1]),
        start.omega_rad_s,
    )  # fmt: skip


def start_state(scene: Scene) -> LinkState:
    """Return the state that a scene starts from, all links, ground frame."""
    start = _explicit_start(scene)
    soft = scene.formulation == "implicit" and scene.joint_stiffness_n_m > 0
    if soft and scene.gap == "slow_manifold" and not isinstance(scene.start, LinkState):
        return _on_slow_manifold(scene, start)
    return start


def simulate(scene: Scene) -> Run:
    """Run a scene and return what it recorded.

    Raises StepTooLarge, before anything runs, when dt_s is outside the method's stability region,
    Diverged when the state leaves the finite numbers, naming the time, and BadInput.
    """
    check_step(scene)
    out = _core.run(
        core_model(scene.robot, scene.ground, scene.gait), scene.formulation == "implicit",
        _torque_function(scene), scene.method == "nonsmooth", scene.joint_stiffness_n_m,
        scene.joint_damping_n_s_m, scene.smoothing_m_s, scene.dt_s, scene.duration_s, scene.steps,
        scene.record_every, "joints" in scene.record, start_state(scene).packed(),
    )  # fmt: skip
    if out["failed_at"] >= 0:
        raise Diverged(
            f"the run left the finite numbers by t = {out['failed_at']:g} s with method "
            f"{scene.method} at dt_s {scene.dt_s:g}; take a smaller step (a tenth is a good try)"
        )
    names = ("t_s", "x_m", "y_m", "theta_rad", "vx_m_s", "vy_m_s", "omega_rad_s")
    joints = ("joint_fx_n", "joint_fy_n", "joint_torque_nm")
    return Run(scene, *(out[name] for name in names + joints))
