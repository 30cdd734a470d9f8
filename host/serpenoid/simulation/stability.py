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
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..model.drives import Servo
from ..model.errors import StepTooLarge
from ..model.evaluation import TorqueDrive, acceleration
from ..model.gait import Gait
from ..model.ground import Ground
from ..model.link_state import LinkState
from .methods import METHODS, objection
from .scene import Scene

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
_PHASES, _MOST_LINKS = 8, 60
_SHORTEST_S = 1e-12
_SLACK = 1e-9  # rounding of |R| on the edge, where undamped modes live


def joint_modes(scene: Scene, any_shape: bool = False) -> Array:
    """Return the largest mu of the chain's joints over a cycle and the smallest, 1/kg, (2,).

    Exact for up to 60 links at eight phases of the gait; above, or for any_shape, the bound that
    holds for any shape and costs nothing.
    """
    robot = scene.robot
    n, m, half = robot.links, robot.link_mass_kg, robot.link_length_m / 2
    turning = 4 * half**2 / robot.inertia_kg_m2
    if any_shape or n > _MOST_LINKS:
        return np.array([4 / m + turning, 0.0])
    found = []
    for phase in np.arange(_PHASES) * math.pi / _PHASES:
        state = LinkState.in_gait(
            robot, scene.gait, phase / scene.gait.omega_rad_s, [0] * 3, [0] * 3
        )
        found.append(np.linalg.eigvalsh(_compliance(scene, state.theta_rad)))
    every = np.array(found)
    return np.array([every.max(), every.min()])


def _compliance(scene: Scene, theta_rad: Array) -> Array:
    """Return J M^-1 J^T, (2(n-1), 2(n-1)), joint by joint, x and y."""
    robot = scene.robot
    n, half = robot.links, robot.link_length_m / 2
    normal = half * np.stack([-np.sin(theta_rad), np.cos(theta_rad)], axis=1)
    laplacian = 2 * np.eye(n - 1) - np.eye(n - 1, k=1) - np.eye(n - 1, k=-1)
    matrix = np.kron(laplacian / robot.link_mass_kg, np.eye(2))
    arm = np.zeros((2 * (n - 1), n))  # of each gap by each link's own angle
    for i in range(n - 1):
        arm[2 * i : 2 * i + 2, i] = normal[i]
        arm[2 * i : 2 * i + 2, i + 1] = normal[i + 1]
    if scene.drive == "angle" and not scene.limp:
        together = arm.sum(axis=1, keepdims=True)
        return matrix + together @ together.T / (n * robot.inertia_kg_m2)
    return matrix + arm @ arm.T / robot.inertia_kg_m2


def _mobility(scene: Scene) -> Array:
    """Return eigenvalues nu of d phi''/d(servo torque), 1/(kg m^2): most and least, (2,).

    Exact for the explicit formulation up to 60 links at eight phases, else the bound of free links.
    """
    robot, joints = scene.robot, scene.robot.links - 1
    if scene.formulation == "implicit" or robot.links > _MOST_LINKS:
        return np.array([4 / robot.inertia_kg_m2, 0.0])
    ground, found = Ground(0.0, 0.0), []
    for phase in np.arange(_PHASES) * math.pi / _PHASES:
        t = phase / scene.gait.omega_rad_s
        state = LinkState.in_gait(robot, scene.gait, t, [0] * 3, [0] * 3)
        still = replace(
            state, vx_m_s=0 * state.x_m, vy_m_s=0 * state.x_m, omega_rad_s=0 * state.x_m
        )
        bends = [
            np.diff(acceleration(robot, ground, still, drive=TorqueDrive(-one)).alpha_rad_s2)
            for one in np.eye(joints)
        ]
        found.append(np.linalg.eigvalsh(np.array(bends)))
    return np.array([np.max(found), max(np.min(found), 0.0)])


def _motor_line(servo: Servo, gait: Gait) -> float:
    """Return torque by speed of a servo at its limit, N m s/rad; 0 if it never gets there.

    It may when an error of half a turn asks for more than is left at ten times the gait's rate.
    """
    left = 1 - 10 * gait.alpha_rad * gait.omega_rad_s / servo.speed_limit_rad_s
    if servo.torque_limit_nm * left > servo.stiffness_nm_rad * math.pi:
        return 0.0
    return servo.torque_limit_nm / servo.speed_limit_rad_s


def _oscillator_rates(stiff: Array, damped: Array) -> Complex:
    """Return both roots of s^2 + damped s + stiff = 0 for each pair."""
    root: Complex = np.sqrt(((damped / 2) ** 2 - stiff).astype(complex))
    return np.concatenate([root - damped / 2, -root - damped / 2])


def _amplification_rk4(z: Complex) -> Complex:
    return 1 + z * (1 + z / 2 * (1 + z / 3 * (1 + z / 4)))


def _rk4_stable(stiff: Array, damped: Array, dt_s: float) -> bool:
    rates = _oscillator_rates(stiff, damped)
    return bool(np.all(abs(_amplification_rk4(rates * dt_s)) <= 1 + _SLACK))


def _euler_stable(stiff: Array, damped: Array, dt_s: float) -> bool:
    """|1 + h s|^2 <= 1 without its rounding: an undamped mode grows, however slowly."""
    rates = _oscillator_rates(stiff, damped)
    return bool(np.all(dt_s * np.abs(rates) ** 2 <= -2 * rates.real * (1 + _SLACK)))


def _semi_implicit_stable(stiff: Array, damped: Array, dt_s: float) -> bool:
    """Jury's conditions for v' = v - h (stiff x + damped v), x' = x + h v'."""
    d, s = damped * dt_s, stiff * dt_s**2
    return bool(np.all(d <= 2 + _SLACK) and np.all(s + 2 * d <= 4 + _SLACK))


def _stick_slip_stable(stiff: Array, damped: Array, dt_s: float) -> bool:
    """Spectral radius of 2 S(h/2)^2 - S(h), S(h) one step of semi-implicit Euler."""

    def plain(h: float) -> Array:
        step = np.empty((stiff.size, 2, 2))  # over (x, v h of the whole step)
        step[:, 1, 0], step[:, 1, 1] = -stiff * h * dt_s, 1 - damped * h
        step[:, 0] = [1, 0] + step[:, 1] * h / dt_s
        return step

    half = plain(dt_s / 2)
    step = 2 * half @ half - plain(dt_s)
    return bool(np.all(np.abs(np.linalg.eigvals(step)) <= 1 + _SLACK))


def _held_dampers_stable(stiff: Array, damped: Array, dt_s: float) -> bool:
    """Spectral radius of one RK4 step of x'' = -stiff x - g, g = damped v of the step before."""
    z2 = stiff * dt_s**2
    even, odd = 1 - z2 / 2 + z2**2 / 24, 1 - z2 / 6  # of RK4's polynomial in h A
    step = np.zeros((stiff.size, 3, 3))  # over (x, v h, v h of the step before)
    step[:, 0, 0], step[:, 0, 1] = even, odd
    step[:, 1, 0], step[:, 1, 1] = -z2 * odd, even
    push = -damped * dt_s  # times (v h) of the step before: constant over the step
    step[:, 0, 2] = push * (0.5 - z2 / 24)
    step[:, 1, 2] = push * odd
    step[:, 2, 1] = 1
    return bool(np.all(np.abs(np.linalg.eigvals(step)) <= 1 + _SLACK))


_RULES = {
    "rk4": _rk4_stable,
    "euler": _euler_stable,
    "semi_implicit": _semi_implicit_stable,
    "stick_slip": _stick_slip_stable,
    "held_dampers": _held_dampers_stable,
}


def modes(scene: Scene, any_shape: bool = False) -> tuple[Array, Array]:
    """Return stiff (1/s^2) and damped (1/s) of the scene's modes s^2 + damped s + stiff = 0.

    Springs of the implicit joints, servos, and friction (stiff = 0).
    """
    ground, mass_kg = scene.ground, scene.robot.link_mass_kg
    friction = max(ground.ct_forward, ground.ct_backward, ground.cn) / mass_kg
    if scene.method == "nonsmooth":
        friction = 0.0  # implicit in that method
    stiff, damped = [np.zeros(1)], [np.array([friction])]
    if scene.smoothing_m_s > 0:
        dry = max(ground.ft0_forward, ground.ft0_backward, ground.fn0) / scene.smoothing_m_s
        damped[0] = damped[0] + dry / mass_kg
    if scene.formulation == "implicit":
        most, least = joint_modes(scene, any_shape)
        mu = np.linspace(least, most, 64)
        stiff.append(scene.joint_stiffness_n_m * mu)
        damped.append(scene.joint_damping_n_s_m * mu)
    if scene.servo is not None:
        most, least = _mobility(scene)
        nu = np.linspace(least, most, 64)
        nu = nu / (1 + scene.servo.armature_kg_m2 * nu)  # rotors turn with their joints
        gear = scene.servo.gear_damping_nms_rad
        stiff += [scene.servo.stiffness_nm_rad * nu, 0 * nu]
        damped += [
            (scene.servo.damping_nms_rad + gear) * nu,
            (_motor_line(scene.servo, scene.gait) + gear) * nu,
        ]
    return np.concatenate(stiff), np.concatenate(damped)


def stability_test(scene: Scene, any_shape: bool = False) -> Callable[[float], bool] | None:
    """Return the question `is this step stable?`, or None for a method that picks its own."""
    if scene.adaptive:
        return None
    stiff, damped = modes(scene, any_shape)
    rule = _RULES[METHODS[scene.method].stability]
    return lambda dt_s: rule(stiff, damped, dt_s)


def largest_step_s(stable: Callable[[float], bool], dt_s: float) -> float:
    """Return a step next to the largest stable one below dt_s, by bisection in its logarithm.

    0 when there is none: explicit Euler makes every undamped mode grow.
    """
    low = dt_s
    for _ in range(200):
        low /= 2
        if stable(low):
            break
    else:
        return 0.0
    high = 2 * low
    for _ in range(40):
        middle = math.sqrt(low * high)
        low, high = (middle, high) if stable(middle) else (low, middle)
    return low


def check_step(scene: Scene) -> None:
    """Raise StepTooLarge, naming a step that works, when a scene's fixed step is unstable."""
    for any_shape in (True, False):  # the modes of the shapes only where the bound does not do
        stable = stability_test(scene, any_shape)
        if stable is None or stable(scene.dt_s):
            return
    limit = largest_step_s(stable, scene.dt_s)
    springs = (
        f" with k = {scene.joint_stiffness_n_m:g} N/m, c = {scene.joint_damping_n_s_m:g} N s/m"
        if scene.formulation == "implicit"
        else ""
    )
    if limit < _SHORTEST_S:
        raise StepTooLarge(
            f"dt_s is {scene.dt_s:g}; method {scene.method} has no stable step for this "
            f"scene{springs}: undamped modes grow with it at any step. {_bounded(scene)}"
        )
    raise StepTooLarge(
        f"dt_s is {scene.dt_s:g}; method {scene.method} is stable up to {limit:.3g} s for this "
        f"scene{springs}. A longer step may look sound and be metres off: take dt_s "
        f"{0.5 * limit:.1g} or less" + (_without_limit(scene) if springs else "")
    )


def _bounded(scene: Scene) -> str:
    """Return which methods have stable steps for a scene, as a sentence's advice."""
    found = []
    for method in ("rk4", "semi_implicit_euler"):
        other = replace(scene, method=method)
        stable = stability_test(other)
        longest = other.dt_s if stable is None else largest_step_s(stable, 2 * other.dt_s)
        if longest >= _SHORTEST_S:
            found.append(f"method {method!r} with dt_s {0.5 * longest:.1g} or less")
    if not found:
        return "No method of fixed steps has one: take softer numbers, or an adaptive method"
    return f"Take {' or '.join(found)}"


def _without_limit(scene: Scene) -> str:
    """Return what to take instead of small steps on hard springs, as the end of a sentence."""
    ways = []
    if objection("radau", scene) is None:
        ways.append("method 'radau', which has no such limit")
    if objection(scene.method, scene, formulation="explicit") is None:
        ways.append("formulation 'explicit', which has no springs")
    return "".join(f", or {way}" for way in ways)
