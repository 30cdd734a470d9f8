"""From a scene to its run: where it starts, its numbers for the core, and what comes back."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from .. import _core
from ..base.checks import CHOICES, check_kind, check_number
from ..base.errors import BadInput, Diverged
from ..base.vectors import Array, finite_vector
from ..model.core_model import core_model
from ..model.drives import TorqueTable, core_servo
from ..model.gait import joint_motion
from ..model.link_state import LinkState, from_tail
from ..periodic.steady import steady_gait
from .accuracy import accurate_run, estimated_error
from .run import Run
from .scene import MAX_LINK_STEPS, Scene, exact_scene, objection
from .stability import check_step, friction_rate

Progress = Callable[[float], object]


def simulate(
    scene: Scene, progress: Progress | None = None, *, accuracy: float | None = None
) -> Run:
    """Run a scene and return what it recorded.

    Parameters
    ----------
    scene
        The run's description.
    progress
        Called now and then with the time in s.
    accuracy
        Largest estimated error, in body lengths and rad. If given, the step or tolerance is chosen
        for it, and the method too unless the scene names one. `Run.picked` says which and why. dt_s
        stays the grid of recorded times: fixed steps are whole parts of it.

    Returns
    -------
    Run
        The record, and its error.

    Raises
    ------
    BadInput
        For a scene that cannot run.
    StepTooLarge
        Before the run, if dt_s is outside the method's stability region.
    Diverged
        If the state leaves the finite numbers or the method gives up; the message has the time.
    NotConverged
        If `accuracy` cannot be reached; the message has the error that was, and why.

    Examples
    --------
    >>> robot = sn.Robot(links=6, link_mass_kg=1.0, link_length_m=0.12)
    >>> ground = sn.Ground(ct=0.1, cn=10.0)
    >>> gait = sn.Gait(alpha_rad=0.5236, beta_rad=1.3963, omega_rad_s=5.0)
    >>> run = sn.simulate(sn.Scene(robot, ground, gait, duration_s=0.5))
    >>> run.x_m.shape[1]
    6
    """
    check_kind("scene", scene, Scene)
    if accuracy is None:
        return run_scene(scene, progress=progress)
    check_number("accuracy", accuracy, 1e-10, 0.1)
    return accurate_run(scene, accuracy, partial(run_scene, progress=progress))


def run_scene(
    scene: Scene,
    start: LinkState | None = None,
    *,
    picked: str = "",
    progress: Progress | None = None,
) -> Run:
    """Run a scene, unless given from its own start; raises StepTooLarge and Diverged."""
    check_step(scene)
    columns = run_core(scene, start or start_state(scene), progress)
    estimator = partial(estimated_error, solve=run_scene)
    return Run(scene=scene, picked=picked, _estimator=estimator, **columns)


def _joints_at_start(scene: Scene) -> tuple[Array, Array]:
    """Return angles and rates of the joints at t = 0: the gait's, locked ones where they stay."""
    phi, rate, _ = joint_motion(scene.gait, scene.robot.links - 1)
    for joint, angle in scene.locked.items():
        phi[joint - 1], rate[joint - 1] = angle, 0.0
    return phi, rate


def _check_imposed(scene: Scene, start: LinkState) -> None:
    """Raise BadInput unless a start has the angles and rates of the joints that are imposed."""
    joints = np.arange(1, scene.robot.links)
    by_angle = scene.drive == "angle"
    imposed = ~np.isin(joints, scene.limp) if by_angle else np.isin(joints, list(scene.locked))
    bent = np.diff(start.theta_rad), np.diff(start.omega_rad_s)
    names = "angle {:.6g} rad", "rate {:.6g} rad/s"
    for name, has, wants in zip(names, bent, _joints_at_start(scene), strict=True):
        wrong = imposed & ~np.isclose(has, wants, rtol=1e-6, atol=1e-6)
        for i in np.nonzero(wrong)[0]:
            raise BadInput(
                f"start has joint {i + 1} at {name.format(has[i])}, where it is imposed to "
                f"be {wants[i]:.6g}; take the state from LinkState.in_gait, or another drive"
            )


def _explicit_start(scene: Scene) -> LinkState:
    """Return the start with pinned joints, link 1 at the origin along x."""
    if isinstance(scene.start, LinkState):
        _check_imposed(scene, scene.start)
        return scene.start
    robot, (phi, rate) = scene.robot, _joints_at_start(scene)
    bent = LinkState.joined(robot, from_tail(np.zeros(3), phi), from_tail(np.zeros(3), rate))
    if scene.start == "link1_at_rest":
        return bent
    x_m, y_m = bent.x_m - bent.x_m.mean(), bent.y_m - bent.y_m.mean()
    vx_m_s, vy_m_s = bent.vx_m_s - bent.vx_m_s.mean(), bent.vy_m_s - bent.vy_m_s.mean()
    if scene.start == "steady":  # link 1 turns as the body velocity says
        state = steady_gait(robot, scene.ground, scene.gait, powers=False)
        ahead_m_s, left_m_s, turn_rad_s = state.body_velocity
    else:  # neither does the centre of mass move nor the whole chain turn
        mass_kg, inertia_kg_m2 = robot.link_mass_kg, robot.inertia_kg_m2
        spin = mass_kg * (x_m @ vy_m_s - y_m @ vx_m_s) + inertia_kg_m2 * bent.omega_rad_s.sum()
        whole_kg_m2 = robot.links * inertia_kg_m2 + mass_kg * (x_m @ x_m + y_m @ y_m)
        ahead_m_s, left_m_s, turn_rad_s = 0.0, 0.0, -spin / whole_kg_m2
    return replace(
        bent,
        vx_m_s=vx_m_s + ahead_m_s - turn_rad_s * y_m,
        vy_m_s=vy_m_s + left_m_s + turn_rad_s * x_m,
        omega_rad_s=bent.omega_rad_s + turn_rad_s,
    )


def _on_slow_manifold(scene: Scene, start: LinkState) -> LinkState:
    """Open the joints by what their springs need to carry the explicit model's forces.

    Gap (F - c F'/k)/k and gap rate F'/k: the motion then has no ringing part to order 1/k^2. The
    centre of mass stays where it is. F' comes from five evaluations along the explicit motion.
    Where friction brakes faster than the springs swing, or wheels stop at once, F is not slow: the
    gap is F/k.
    """
    k, c = scene.joint_stiffness_n_m, scene.joint_damping_n_s_m
    m, braking = scene.robot.link_mass_kg, friction_rate(scene)
    # A step is 1 mrad of the gait, 1 % of the time in which friction brakes, and 10 us for torques.
    fastest = max(1e3 * scene.gait.omega_rad_s, 100 * braking, 1e5 * (scene.drive != "angle"))
    h = max(1 / fastest, 1e-12)
    short = replace(scene, start=start, dt_s=h, duration_s=4 * h, record_every=1)
    exact = replace(exact_scene(short, 1e-9), record=("joints",))
    record = run_core(exact, start)
    force = np.stack([record["joint_force_x_n"], record["joint_force_y_n"]], axis=2)  # (5, n-1, 2)
    rate = np.tensordot([-25, 48, -36, 16, -3], force, axes=1) / (12 * h)
    lag = c / k + math.sqrt(m / k)
    mode_ends = scene.law == "dry" and np.abs(rate).max() * lag > np.abs(force[0]).max()
    if braking * lag > 1 or mode_ends:
        rate *= 0
    gap, gap_rate = (force[0] - c * rate / k) / k, rate / k
    widest = float(np.abs(gap).max())
    if not widest < scene.robot.link_length_m:
        raise BadInput(
            f"the springs ({k:g} N/m) would begin {widest:.3g} m apart, more than a link "
            f"({scene.robot.link_length_m:g} m); take gap 'zero', or a larger joint_stiffness_n_m"
        )

    shifts = np.vstack([np.zeros(4), np.hstack([gap, gap_rate]).cumsum(axis=0)])
    state = start.packed().reshape(6, -1)
    state[[0, 1, 3, 4]] += (shifts - shifts.mean(axis=0)).T  # x, y and their rates
    return LinkState(*state)


def start_state(scene: Scene) -> LinkState:
    """Return the state that a scene starts from, all links, ground frame."""
    start = _explicit_start(scene)
    soft = scene.formulation == "implicit" and scene.joint_stiffness_n_m > 0
    if soft and scene.gap == "slow_manifold" and not isinstance(scene.start, LinkState):
        return _on_slow_manifold(scene, start)
    return start


def run_core(scene: Scene, start: LinkState, progress: Progress | None = None) -> dict[str, Any]:
    """Run a scene from a start and return Run's arrays by name (module.cpp); or raise Diverged."""
    q = _core.RunRequest(core_model(scene.robot, scene.ground, scene.gait))
    q.choose(scene.formulation, scene.drive, scene.method)
    for name in _core.SCENE_FIELDS:
        setattr(q, name, getattr(scene, name))
    if scene.incline_rad > 0:
        downhill = -9.80665 * math.sin(scene.incline_rad)
        direction = scene.incline_direction_rad
        q.set_slope(downhill * math.cos(direction), downhill * math.sin(direction))
    if isinstance(scene.torque, TorqueTable):
        q.set_torque_table(scene.torque.t_s.tolist(), scene.torque.torque_nm.ravel().tolist())
    elif callable(torque := scene.torque):
        size = scene.robot.links - 1
        q.set_torque_function(lambda t: finite_vector(f"torque at {t:g} s", torque(t), size))
    if scene.servo is not None:
        q.servo = core_servo(scene.servo)
    if scene.limp or scene.locked:
        q.set_faults(scene.limp, scene.locked)
    q.max_steps = MAX_LINK_STEPS // scene.robot.links
    for name in CHOICES["record"]:
        setattr(q, f"record_{name}", name in scene.record)
    columns = _core.run(q, start.packed(), progress)
    failed_at, why = columns.pop("failed_at"), columns.pop("why")
    if failed_at >= 0:
        raise Diverged(_what_failed(scene, failed_at, why))
    return columns


def _what_failed(scene: Scene, t_s: float, why: str) -> str:
    what = why or "the state grew without bound"
    if "stiff" in why and objection("radau", scene) is None:
        cure = "take method 'radau', which is made for stiff springs"
    elif scene.adaptive:
        cure = f"loosen tolerance {scene.tolerance:g}, or look whether the scene is physical"
    else:
        cure = f"take a smaller dt_s than {scene.dt_s:g} (a tenth is a good try)"
    return f"the run ended by t = {t_s:g} s with method {scene.method}: {what}; {cure}"
