"""Runs in time: start states, one call of the core, and a Run with everything it recorded."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..model.core_model import core_model
from ..model.drives import TorqueTable
from ..model.errors import BadInput, Diverged
from ..model.link_state import LinkState
from ..model.vectors import finite_vector
from ..periodic.steady import steady_gait
from .accuracy import simulate_to
from .error import RunError, estimate, warnings_of
from .scene import MAX_LINK_STEPS, Scene
from .stability import check_step

Array = NDArray[np.float64]
STANDARD_GRAVITY_M_S2 = 9.80665
_FORWARD = np.array([-25.0, 48.0, -36.0, 16.0, -3.0]) / 12.0  # derivative from five points, order 4


ENERGY_COLUMNS = (
    "kinetic_j", "springs_j", "height_j", "joint_work_j", "friction_heat_j", "damper_heat_j",
    "positive_work_j",
)  # fmt: skip


@dataclass(frozen=True)
class Run:
    """Hold a run: T recorded times t_s (T,), and (T, n) arrays over links counted from the tail.

    x_m, y_m: link centres, theta_rad: angles, vx_m_s, vy_m_s, omega_rad_s: their rates, ground
    frame. Empty unless recorded: joint_force_x_n, joint_force_y_n, joint_torque_nm, (T, n-1), on
    link i from link i+1 ("joints"); friction_x_n, friction_y_n, (T, n), of the ground on each link
    ("friction"); energy_j, (T, 7), columns ENERGY_COLUMNS: three stores, then what joints, friction
    and dampers did since t = 0 and the work of joints that do not regenerate ("energy").
    picked: what an accuracy that was asked for chose, and why (else empty).
    steps: how many the method took. local_error: sum of the errors that an adaptive method thinks
    its steps made, in the scale of scene.tolerance (0: it has no idea).
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
    friction_x_n: Array
    friction_y_n: Array
    energy_j: Array
    steps: int
    local_error: float
    picked: str = ""

    def state(self, index: int = -1) -> LinkState:
        """Return the state of all links at one recorded time."""
        return LinkState.row(self, index)

    @cached_property
    def error_estimate(self) -> RunError:
        """Return what is known of this run's error; the first use costs one or two more runs."""
        return estimate(self, simulate)

    @cached_property
    def warnings(self) -> tuple[str, ...]:
        """Return what somebody who uses this run must know; costs what error_estimate costs."""
        return warnings_of(self, self.error_estimate)

    @property
    def joint_power_w(self) -> Array:
        """Return -T_i phi_i', the mechanical power of each joint, (T, n-1)."""
        return -self.joint_torque_nm * np.diff(self.omega_rad_s, axis=1)

    @property
    def gap_m(self) -> Array:
        """Return Delta_i, how far each joint is open (Eqs. 53-56), (T, n-1, 2)."""
        half = self.scene.robot.link_length_m / 2

        def open_by(centre: Array, along: Array) -> Array:
            return np.diff(centre, axis=1) - half * (along[:, 1:] + along[:, :-1])

        gap_x = open_by(self.x_m, np.cos(self.theta_rad))
        return np.stack([gap_x, open_by(self.y_m, np.sin(self.theta_rad))], axis=2)


_FROM_CORE = tuple(f.name for f in dataclasses.fields(Run))[1:-1]  # but scene and picked


def _joints_at_start(scene: Scene) -> tuple[Array, Array]:
    """Return angles and rates of the joints at t = 0: the gait's, locked ones where they stay."""
    gait, joints = scene.gait, np.arange(scene.robot.links - 1)
    phase = gait.beta_rad * joints
    phi = gait.offset_rad + gait.alpha_rad * np.sin(phase)
    rate = gait.omega_rad_s * gait.alpha_rad * np.cos(phase)
    for joint, angle in scene.locked.items():
        phi[joint - 1], rate[joint - 1] = angle, 0.0
    return phi, rate


def _placed(scene: Scene, vx_m_s: float, vy_m_s: float, omega_rad_s: float) -> LinkState:
    """Return the state with link 1 at the origin along x, moving as given."""
    phi, rate = _joints_at_start(scene)
    q, qdot = np.zeros(scene.robot.links + 2), np.empty(scene.robot.links + 2)
    q[3:] = phi.cumsum()
    qdot[:3] = vx_m_s, vy_m_s, omega_rad_s
    qdot[3:] = omega_rad_s + rate.cumsum()
    return LinkState.joined(scene.robot, q, qdot)


def _zero_momentum(scene: Scene) -> LinkState:
    """Return the start in which neither the centre of mass moves nor the whole chain turns."""
    robot = scene.robot
    at_rest = _placed(scene, 0, 0, 0)
    m, inertia = robot.link_mass_kg, robot.inertia_kg_m2
    x, y = at_rest.x_m - at_rest.x_m.mean(), at_rest.y_m - at_rest.y_m.mean()
    vx, vy = at_rest.vx_m_s - at_rest.vx_m_s.mean(), at_rest.vy_m_s - at_rest.vy_m_s.mean()
    momentum = m * (x @ vy - y @ vx) + inertia * at_rest.omega_rad_s.sum()
    turn = -momentum / (robot.links * inertia + m * (x @ x + y @ y))
    shift_x, shift_y = -at_rest.vx_m_s.mean() - turn * y[0], -at_rest.vy_m_s.mean() + turn * x[0]
    return _placed(scene, shift_x, shift_y, turn)


def _steady_start(scene: Scene) -> LinkState:
    """Return the explicit model's periodic state, link 1 at the origin heading along x."""
    robot, gait = scene.robot, scene.gait
    u = steady_gait(robot, scene.ground, gait, powers=False).body_velocity
    at_rest = _placed(scene, 0, 0, 0)
    # link 1 moves as the centre of mass does, turned about it, less what the shape adds
    dx, dy = at_rest.x_m[0] - at_rest.x_m.mean(), at_rest.y_m[0] - at_rest.y_m.mean()
    vx = u[0] - u[2] * dy - at_rest.vx_m_s.mean()
    vy = u[1] + u[2] * dx - at_rest.vy_m_s.mean()
    return _placed(scene, vx, vy, u[2])


def _check_imposed(scene: Scene, start: LinkState) -> None:
    """Raise BadInput unless a start has the angles and rates of the joints that are imposed."""
    phi, rate = _joints_at_start(scene)
    for i in range(scene.robot.links - 1):
        if (scene.drive != "angle" or i + 1 in scene.limp) and i + 1 not in scene.locked:
            continue
        found = (start.theta_rad[i + 1] - start.theta_rad[i],
                 start.omega_rad_s[i + 1] - start.omega_rad_s[i])  # fmt: skip
        for what, unit, has, wants in zip(
            ("angle", "rate"), ("rad", "rad/s"), found, (phi[i], rate[i]), strict=True
        ):
            if abs(has - wants) > 1e-6 * (1 + abs(wants)):
                raise BadInput(
                    f"start has joint {i + 1} at {what} {has:.6g} {unit}, where it is imposed to "
                    f"be {wants:.6g}; take the state from LinkState.in_gait, or another drive"
                )


def _explicit_start(scene: Scene) -> LinkState:
    if isinstance(scene.start, LinkState):
        return scene.start
    if scene.start == "zero_momentum":
        return _zero_momentum(scene)
    if scene.start == "steady":
        return _steady_start(scene)
    return _placed(scene, 0, 0, 0)


def _on_slow_manifold(scene: Scene, start: LinkState) -> LinkState:
    """Open the joints by what their springs need to carry the explicit model's forces.

    Gap (F - c F'/k)/k and gap rate F'/k: the motion then has no ringing part to order 1/k^2. The
    centre of mass stays where it is. F' comes from five evaluations along the explicit motion.
    """
    h = 1e-3 / scene.gait.omega_rad_s
    if scene.drive != "angle":
        h = min(h, 1e-5)
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


def _torque(request: Any, scene: Scene) -> None:
    torque, joints = scene.torque, scene.robot.links - 1
    if isinstance(torque, TorqueTable):
        request.set_torque_table(torque.t_s.tolist(), torque.torque_nm.ravel().tolist())
    elif callable(torque):
        request.set_torque_function(
            lambda t: finite_vector(f"torque at {t:g} s", torque(t), joints)
        )
    elif torque is not None:
        request.set_torque_table([0.0], finite_vector("torque", torque, joints).tolist())


def _faults(scene: Scene) -> tuple[list[Any], list[float]]:
    """Return what is wrong with each joint, and the angles of the locked; empty if nothing is."""
    if not scene.limp and not scene.locked:
        return [], []
    kinds = dict.fromkeys(scene.limp, _core.Fault.limp)
    kinds |= dict.fromkeys(scene.locked, _core.Fault.locked)
    numbers = range(1, scene.robot.links)
    return [kinds.get(j, _core.Fault.none) for j in numbers], [
        scene.locked.get(j, 0.0) for j in numbers
    ]


def core_request(scene: Scene) -> Any:
    """Return a scene as the core takes it."""
    q = _core.RunRequest(core_model(scene.robot, scene.ground, scene.gait))
    q.formulation = getattr(_core.Formulation, scene.formulation)
    q.drive = getattr(_core.Drive, scene.drive)
    q.set_spring(scene.joint_stiffness_n_m, scene.joint_damping_n_s_m)
    if scene.incline_rad > 0:
        downhill = -STANDARD_GRAVITY_M_S2 * math.sin(scene.incline_rad)
        direction = scene.incline_direction_rad
        q.set_slope(downhill * math.cos(direction), downhill * math.sin(direction))
    _torque(q, scene)
    if scene.servo is not None:
        q.set_servo(*(getattr(scene.servo, name) for name in scene.servo.__slots__))
    q.faults, q.locked_rad = _faults(scene)
    q.smoothing_m_s = scene.smoothing_m_s
    q.method, q.dt_s, q.tolerance = scene.method, scene.dt_s, scene.tolerance
    q.duration_s, q.steps, q.every = scene.duration_s, scene.steps, scene.every
    q.most_steps = MAX_LINK_STEPS // scene.robot.links
    q.record_joints = "joints" in scene.record
    q.record_friction = "friction" in scene.record
    q.record_energy = "energy" in scene.record
    return q


def simulate(
    scene: Scene,
    progress: Callable[[float], object] | None = None,
    *,
    accuracy: float | None = None,
) -> Run:
    """Run a scene and return what it recorded; progress is called with the time, now and then.

    accuracy: if given, formulation, method and step are chosen so that the estimated error stays
    below it, in body lengths and radians, and Run.picked says which and why (accuracy.py).
    Raises StepTooLarge, before anything runs, when dt_s is outside the method's stability region,
    Diverged when the state leaves the finite numbers or the method gives up, naming the time, and
    BadInput.
    """
    if accuracy is not None:
        return simulate_to(accuracy, scene, lambda one: simulate(one, progress))
    check_step(scene)
    if isinstance(scene.start, LinkState):
        _check_imposed(scene, scene.start)
    out = _core.run(core_request(scene), start_state(scene).packed(), progress)
    if out["failed_at"] >= 0:
        raise Diverged(_what_failed(scene, out["failed_at"], out["why"]))
    return Run(scene, *map(out.__getitem__, _FROM_CORE))


def _what_failed(scene: Scene, t_s: float, why: str) -> str:
    what = why or "the state left the finite numbers"
    if "stiff" in why and scene.formulation == "implicit":
        cure = "take method 'radau', which is made for stiff springs"
    elif scene.adaptive:
        cure = f"loosen tolerance {scene.tolerance:g}, or look whether the scene is physical"
    else:
        cure = f"take a smaller dt_s than {scene.dt_s:g} (a tenth is a good try)"
    return f"the run ended by t = {t_s:g} s with method {scene.method}: {what}; {cure}"
