"""MuJoCo on the exact model: what of the scene it can say, and how.

Comparable: the links, their inertia and start, and the ground, as one damper along and one across
each link (an actuator at the link's centre, which MuJoCo's implicit integrators treat implicitly).
Not comparable: MuJoCo cannot impose joint angles. They are held here by equality constraints with
the gait's angle, rate and acceleration fed forward, renewed every step, so the gait itself is kept
only to the order of the integrator; and it computes in three dimensions. Dry friction of a
set-valued, anisotropic kind, ratchet wheels (a damper is the same both ways) and the springs of the
implicit model are left out.
"""

from __future__ import annotations

import mujoco as mj  # pyright: ignore[reportMissingImports] (an optional extra)
import numpy as np

from ..contender import Contender, Work, check_smooth, even_step_s
from ..problems import Array, Problem

STEPS_S = (1e-2, 3e-3, 1e-3, 3e-4, 1e-4)


def mujoco(problem: Problem) -> list[Contender]:
    """Return MuJoCo's implicitfast integrator, where it can state the problem.

    Its RK4 is left out: with constraints renewed once a step it stays at an error of 1e-2.
    """
    if problem.implicit or not problem.ground.smooth:
        return []
    return [Contender("MuJoCo implicitfast", "MuJoCo", "dt_s", STEPS_S, _work)]


def _model_text(problem: Problem, dt_s: float) -> str:
    """Return the scene in MuJoCo's language: link 1 on two slides and a hinge, the rest hinged."""
    r, g = problem.robot, problem.ground
    check_smooth("MuJoCo", g)
    half, inertia = r.link_length_m / 2, r.inertia_kg_m2
    bodies, dampers, held = "", "", ""
    for i in range(r.links):
        root = (
            '<joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 1 0"/>'
            '<joint type="hinge" axis="0 0 1"/>'
        )
        hinge = f'<joint name="j{i}" type="hinge" axis="0 0 1" pos="{-half} 0 0"/>'
        bodies += (
            f'<body pos="{2 * half if i else 0} 0 0">{hinge if i else root}'
            f'<inertial pos="0 0 0" mass="{r.link_mass_kg}" '
            f'diaginertia="{inertia} {inertia} {inertia}"/><site name="s{i}"/>'
        )
        for axis, c in (("1 0 0", g.ct_forward), ("0 1 0", g.cn)):
            dampers += (
                f'<general site="s{i}" gear="{axis} 0 0 0" gainprm="0" biastype="affine" '
                f'biasprm="0 0 {-c}"/>'
            )
        if i:
            held += (
                f'<joint joint1="j{i}" solref="{2 * dt_s} 1" solimp="0.9999 0.9999 1e-3 0.5 1"/>'
            )
    return (
        f'<mujoco><option timestep="{dt_s}" gravity="0 0 0" integrator="implicitfast" '
        f'tolerance="1e-14"><flag contact="disable"/></option><worldbody>{bodies}'
        f"{'</body>' * r.links}</worldbody><actuator>{dampers}</actuator>"
        f"<equality>{held}</equality></mujoco>"
    )


def _work(problem: Problem, dt_s: float) -> Work:
    dt_s = even_step_s(problem, dt_s)
    model = mj.MjModel.from_xml_string(_model_text(problem, dt_s))  # type: ignore
    gait, joints = problem.gait, problem.robot.links - 1
    steps, lag = round(problem.duration_s / dt_s), gait.beta_rad * np.arange(joints)
    first = problem.first
    # the constraint asks for q'' = -b q' - k (q - target); so this target asks for the gait's own
    k, b = 1 / (0.9999 * 2 * dt_s) ** 2, 2 / (0.9999 * 2 * dt_s)

    def work() -> Array:
        data = mj.MjData(model)  # type: ignore
        data.qpos[:3], data.qvel[:3] = first[:3], first[3:]
        data.qpos[3:] = gait.offset_rad + gait.alpha_rad * np.sin(lag)
        data.qvel[3:] = gait.omega_rad_s * gait.alpha_rad * np.cos(lag)
        w, target = gait.omega_rad_s, model.eq_data[:, 0]
        for i in range(steps):
            phase = w * (i + 0.5) * dt_s + lag
            sine, cosine = gait.alpha_rad * np.sin(phase), gait.alpha_rad * np.cos(phase)
            target[:] = gait.offset_rad + sine + b / k * w * cosine - w * w / k * sine
            mj.mj_step(model, data)  # type: ignore
        return np.concatenate([data.qpos[:3], data.qvel[:3]])

    return work
