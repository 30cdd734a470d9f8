"""Check before a run whether a fixed step is inside its method's stability region.

The joints of the implicit model are springs. Let J be the derivative of the gaps by the
coordinates and M the masses. The modes of the chain obey x'' + c mu x' + k mu x = 0, with mu the
eigenvalues of J M^-1 J^T. Angles imposed: the links' centres move and all turn together, so

    J M^-1 J^T = (1/m) (Laplacian of the joints) x 1 + r r^T/(n I),   r_i = l (n_i + n_{i+1});

torques imposed: every link turns by itself, r_i's blocks stand on the diagonal and beside it (with
some joints imposed and some free the modes lie between; the higher bound is taken). Servos are
springs of the joint angles: phi'' + d nu phi' + p nu phi = 0 with nu the eigenvalues of the joints'
mobility; one at its limit is damped by the motor's own line. A run whose step is a few per cent
too long may stay finite and be a metre wrong, without any NaN.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from ..base.errors import StepTooLarge
from ..base.vectors import Array
from ..model.gait import Gait, joint_motion
from ..model.robot import Robot
from .scene import Scene, objection

EXACT_LINKS = 60  # Largest robot with exact modes, which then take seconds; above it a bound holds.


def _shapes(robot: Robot, gait: Gait) -> Array:
    """Return the links' angles of a robot in the shapes of a gait at eight phases, (8, n)."""
    phases = np.linspace(0.0, math.pi, 8, endpoint=False)
    bends = joint_motion(gait, robot.links - 1, phases / gait.omega_rad_s)[0]
    return np.pad(bends.cumsum(axis=1), ((0, 0), (1, 0)))


@lru_cache
def _joint_modes(robot: Robot, gait: Gait, imposed: bool) -> float:
    """Return the largest mu of the chain's joints over a cycle, 1/kg."""
    if robot.links > EXACT_LINKS:
        return 4 / robot.link_mass_kg + robot.link_length_m**2 / robot.inertia_kg_m2
    compliances = [_compliance(robot, theta, imposed) for theta in _shapes(robot, gait)]
    return float(np.linalg.eigvalsh(compliances).max())


def _compliance(robot: Robot, theta_rad: Array, imposed: bool) -> Array:
    """Return J M^-1 J^T, (2(n-1), 2(n-1)), joint by joint, x and y; imposed: links turn as one."""
    n, half = robot.links, robot.link_length_m / 2
    normal = half * np.stack([-np.sin(theta_rad), np.cos(theta_rad)], axis=1)
    meets = np.eye(n - 1, n) + np.eye(n - 1, n, k=1)  # Incidence of joints and links.
    # Derivatives of the gaps by the links' angles.
    arm = np.einsum("il,ld->idl", meets, normal).reshape(-1, n)
    if imposed:
        arm = arm.sum(axis=1, keepdims=True) / math.sqrt(n)
    apart = np.diff(np.eye(n), axis=0)
    shifts = np.kron(apart @ apart.T / robot.link_mass_kg, np.eye(2))
    return shifts + arm @ arm.T / robot.inertia_kg_m2


@lru_cache
def _mobility(robot: Robot, gait: Gait, pinned: bool) -> float:
    """Return the largest eigenvalue nu of d phi''/d(servo torque), 1/(kg m^2)."""
    n = robot.links
    if n > EXACT_LINKS or not pinned:
        return 4 / robot.inertia_kg_m2  # The bound for free links.
    # Derivatives of the links' centres by their angles.
    arms = robot.link_length_m / 2 * (np.tri(n) + np.tri(n, k=-1))
    arms -= arms.mean(axis=0)
    theta_rad = _shapes(robot, gait)
    along = np.cos(theta_rad[:, :, None] - theta_rad[:, None])
    masses = robot.inertia_kg_m2 * np.eye(n) + robot.link_mass_kg * (arms.T @ arms) * along
    apart = np.diff(np.eye(n), axis=0)
    return float(np.linalg.eigvalsh(apart @ np.linalg.solve(masses, apart.T)).max())


def _step(method: str, stiff: Array, damped: Array, braked: Array) -> Array:
    """Return the matrix of a step for (x, h v) of each mode, (modes, size, size).

    stiff, damped, braked: of each mode, times h^2, h and h. The state of "paper" has h v of the
    step before too, on which its dampers act.
    """
    size = 3 if method == "paper" else 2
    unit = np.broadcast_to(np.eye(size)[:, None], (size, stiff.size, size))

    def force(y: Array) -> Array:
        return -(stiff[:, None] * y[0] + damped[:, None] * y[-1] + braked[:, None] * y[1])

    def kick(y: Array, part: float) -> Array:
        v = y[1] + part * force(y)
        return np.stack([y[0] + part * v, v])

    if method == "nonsmooth":
        return np.moveaxis(2 * kick(kick(unit, 0.5), 0.5) - kick(unit, 1.0), 0, 1)
    y = unit
    for part in (4, 3, 2, 1):  # The classical method for linear forces.
        rates = np.zeros_like(y)
        rates[:2] = y[1], force(y)
        y = unit + rates / part
    y[2:] = unit[1]
    return np.moveaxis(y, 0, 1)


def friction_rate(scene: Scene) -> float:
    """Return the largest rate at which viscous friction brakes a link, 1/s."""
    ground = scene.ground
    return max(ground.ct_forward, ground.ct_backward, ground.cn) / scene.robot.link_mass_kg


def _modes(scene: Scene) -> tuple[Array, Array, Array]:
    """Return stiff (1/s^2), damped and braked (1/s) of the modes x'' + (d + b) x' + s x = 0.

    They are the fastest mode of the implicit joints' springs and that of servos (slower ones have
    the same limit), and friction (s = 0). Every mode is also taken with the friction's largest
    rate, b.
    """
    # The method "nonsmooth" steps friction implicitly.
    friction = 0.0 if scene.method == "nonsmooth" else friction_rate(scene)
    modes, implicit = [(0.0, 0.0)], scene.formulation == "implicit"
    if implicit:
        imposed = scene.drive == "angle" and not scene.limp
        mu = _joint_modes(scene.robot, scene.gait, imposed)
        modes.append((scene.joint_stiffness_n_m * mu, scene.joint_damping_n_s_m * mu))
    if (servo := scene.servo) is not None:
        nu = _mobility(scene.robot, scene.gait, not implicit)
        nu /= 1 + servo.armature_kg_m2 * nu  # Rotors turn with their joints.
        gear, gait = servo.gear_damping_nms_rad, scene.gait
        modes.append((servo.stiffness_nm_rad * nu, (servo.damping_nms_rad + gear) * nu))
        # At its torque limit the motor is damped by its torque-speed line. A servo may reach the
        # limit if an error of half a turn needs more torque than is left at ten times the rate.
        torque_share = 1 - 10 * gait.alpha_rad * gait.omega_rad_s / servo.speed_limit_rad_s
        limited = servo.torque_limit_nm * torque_share <= servo.stiffness_nm_rad * math.pi
        line = limited * servo.torque_limit_nm / servo.speed_limit_rad_s
        modes.append((0.0, (line + gear) * nu))
    stiff, damped = np.array(modes * 2).T
    return stiff, damped, np.repeat([0.0, friction], len(modes))


def is_stable(scene: Scene, dt_s: float, edge: float = 1 + 1e-7) -> bool:
    """Return whether a step of a scene is stable; an adaptive method always is.

    The matrices of this step and of shorter ones must have no eigenvalue beyond 1 in magnitude: the
    paper's method has windows of longer stable steps. edge: largest magnitude, with rounding.
    """
    if scene.adaptive:
        return True
    stiff, damped, braked = _modes(scene)
    # Forty shorter steps, down to 0.03 of it, must be stable too.
    steps_s = dt_s * np.geomspace(0.03, 1.0, 40)[:, None]
    with np.errstate(all="ignore"):
        numbers = stiff * steps_s**2, damped * steps_s, braked * steps_s
        matrices = _step(scene.method, *(number.ravel() for number in numbers))
    if not np.isfinite(matrices).all():
        return False
    # Undamped modes have magnitude 1.
    return bool(np.abs(np.linalg.eigvals(matrices)).max() <= edge)


def largest_stable_step_s(scene: Scene) -> float:
    """Return the largest fixed step, s, below which all are stable; inf if there is no limit."""
    low_s, high_s = 1e-60, 1e9
    if is_stable(scene, high_s):
        return math.inf
    # 45 halvings of the logarithm give the limit to 5e-12.
    for _ in range(45):
        middle_s = math.sqrt(low_s * high_s)
        low_s, high_s = (middle_s, high_s) if is_stable(scene, middle_s) else (low_s, middle_s)
    return low_s


def check_step(scene: Scene) -> None:
    """Raise StepTooLarge, with a step that works, if a scene's fixed step is unstable."""
    if is_stable(scene, scene.dt_s):
        return
    limit = largest_stable_step_s(scene)
    cure = f"take dt_s {0.5 * limit:.1g} or less"
    if objection("radau", scene) is None:
        cure += ", or method 'radau', which has no such limit"
    raise StepTooLarge(
        f"dt_s is {scene.dt_s:g}; method {scene.method} is stable up to {limit:.3g} s for this "
        f"scene. A longer step may look sound and be metres off: {cure}"
    )
