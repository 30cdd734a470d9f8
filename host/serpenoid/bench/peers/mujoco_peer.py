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

from functools import partial

import mujoco as mj  # pyright: ignore[reportMissingImports] (an optional extra)
import numpy as np

from ...exchange.mjcf import to_mjcf
from ..problems import Array, Problem
from .contender import Contender, Work, even_step_s

STEPS_S = (1e-2, 3e-3, 1e-3, 3e-4, 1e-4)


def mujoco(problem: Problem) -> list[Contender]:
    """Return MuJoCo's implicitfast integrator, where it can state the problem.

    Its RK4 is left out: with constraints renewed once a step it stays at an error of 1e-2.
    """
    if problem.implicit or not problem.ground.smooth:
        return []
    return [Contender("MuJoCo implicitfast", "MuJoCo", "dt_s", STEPS_S, partial(_work, problem))]


def _model_text(problem: Problem, dt_s: float) -> str:
    """Return the scene in MuJoCo's language, its joints held by constraints."""
    solver = f'solref="{2 * dt_s} 1" solimp="0.9999 0.9999 1e-3 0.5 1"'
    held = "".join(f'<joint joint1="joint{i}" {solver}/>' for i in range(1, problem.robot.links))
    text = to_mjcf(problem.robot, problem.ground, timestep_s=dt_s)
    text = text.replace('integrator="RK4"', 'integrator="implicitfast" tolerance="1e-14"')
    return text.replace("</mujoco>", f"<equality>{held}</equality></mujoco>")


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
