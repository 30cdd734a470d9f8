"""Whether a fixed step is inside its method's stability region: asked before a run.

The joints of the implicit model are springs. With J the derivative of the gaps by the coordinates
and M the masses, the modes of the chain have mu = eigenvalues of J M^-1 J^T and obey
x'' + c mu x' + k mu x = 0. Angles imposed: the links' centres move and all turn together, so

    J M^-1 J^T = (1/m) (Laplacian of the joints) x 1 + r r^T/(n I),   r_i = l (n_i + n_{i+1});

torques imposed: every link turns by itself, r_i's blocks stand on the diagonal and beside it. A
step too long by a few per cent may stay finite and bounded and be a metre wrong: no NaN tells.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from .dynamics import LinkState
from .errors import StepTooLarge
from .scene import Scene

Array = NDArray[np.float64]
_PHASES, _MOST_LINKS = 8, 60
_SLACK = 1e-9  # rounding of |R| on the edge, where undamped modes live


def joint_modes(scene: Scene) -> Array:
    """Return the largest mu of the chain's joints over a cycle and the smallest, 1/kg, (2,).

    Exact for up to 60 links at eight phases of the gait; above, the bound that holds for any shape.
    """
    robot = scene.robot
    n, m, half = robot.links, robot.link_mass_kg, robot.link_length_m / 2
    turning = 4 * half**2 / robot.inertia_kg_m2
    if n > _MOST_LINKS:
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
    if scene.drive == "angle":
        together = arm.sum(axis=1, keepdims=True)
        return matrix + together @ together.T / (n * robot.inertia_kg_m2)
    return matrix + arm @ arm.T / robot.inertia_kg_m2


def _rk4_stable(rates: NDArray[np.complex128], dt_s: float) -> bool:
    z = rates * dt_s
    return bool(np.all(abs(1 + z * (1 + z / 2 * (1 + z / 3 * (1 + z / 4)))) <= 1 + _SLACK))


def _modal_rates(scene: Scene, mu: Array) -> NDArray[np.complex128]:
    """Return both roots of s^2 + c mu s + k mu = 0 for each mu, and the decay of friction, 1/s."""
    k, c = scene.joint_stiffness_n_m, scene.joint_damping_n_s_m
    root = np.sqrt((c * mu / 2) ** 2 - k * mu + 0j)
    friction = -max(scene.ground.ct, scene.ground.cn) / scene.robot.link_mass_kg
    return np.concatenate([-c * mu / 2 + root, -c * mu / 2 - root, [friction + 0j]])


def _semi_implicit_stable(scene: Scene, mu: Array, dt_s: float) -> bool:
    """Jury's conditions for v' = v - h (k mu x + c mu v), x' = x + h v'."""
    k, c = scene.joint_stiffness_n_m, scene.joint_damping_n_s_m
    damped, stiff = c * mu * dt_s, k * mu * dt_s**2
    return bool(np.all(damped <= 2) and np.all(stiff + 2 * damped <= 4))


def _test(scene: Scene) -> Callable[[float], bool] | None:
    """Return the question `is this step stable?`, or None where every step is."""
    if scene.formulation == "explicit":
        if scene.method != "rk4":
            return None  # adaptive
        rates = _modal_rates(scene, np.empty(0))
        return lambda dt: _rk4_stable(rates, dt)
    most, least = joint_modes(scene)
    mu = np.linspace(least, most, 64)
    if scene.method == "rk4":
        rates = _modal_rates(scene, mu)
        return lambda dt: _rk4_stable(rates, dt)
    return lambda dt: _semi_implicit_stable(scene, mu, dt)


def largest_step_s(stable: Callable[[float], bool], dt_s: float) -> float:
    """Return a step next to the largest stable one below dt_s, by bisection in its logarithm."""
    low, high = dt_s, dt_s
    for _ in range(200):
        low /= 2
        if stable(low):
            break
    for _ in range(40):
        middle = math.sqrt(low * high)
        low, high = (middle, high) if stable(middle) else (low, middle)
    return low


def check_step(scene: Scene) -> None:
    """Raise StepTooLarge, naming a step that works, when a scene's fixed step is unstable."""
    stable = _test(scene)
    if stable is None or stable(scene.dt_s):
        return
    limit = largest_step_s(stable, scene.dt_s)
    springs = (
        f" with k = {scene.joint_stiffness_n_m:g} N/m, c = {scene.joint_damping_n_s_m:g} N s/m"
        if scene.formulation == "implicit"
        else ""
    )
    raise StepTooLarge(
        f"dt_s is {scene.dt_s:g}; method {scene.method} is stable up to {limit:.3g} s for this "
        f"robot and ground{springs}. A longer step may look sound and be metres off: take dt_s "
        f"{0.5 * limit:.1g} or less, or formulation 'explicit', which has no springs"
    )
