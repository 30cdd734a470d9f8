"""One call of the compiled core: a scene as the core takes it, and what comes back."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from .. import _core
from ..base.checks import RECORDS
from ..base.errors import Diverged
from ..base.vectors import finite_vector
from ..model.core_model import core_model
from ..model.drives import TorqueTable, core_servo
from ..model.link_state import LinkState
from .scene import MAX_LINK_STEPS, Scene, objection

Progress = Callable[[float], object]
STANDARD_GRAVITY_M_S2 = 9.80665
ENERGY_COLUMNS = (
    "kinetic_j",
    "springs_j",
    "height_j",
    "joint_work_j",
    "friction_heat_j",
    "damper_heat_j",
    "positive_work_j",
)


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


def core_request(scene: Scene) -> Any:
    """Return a scene as the core takes it."""
    q = _core.RunRequest(core_model(scene.robot, scene.ground, scene.gait))
    q.formulation = getattr(_core.Formulation, scene.formulation)
    q.drive = getattr(_core.Drive, scene.drive)
    for name in _core.SCENE_FIELDS:
        setattr(q, name, getattr(scene, name))
    if scene.incline_rad > 0:
        downhill = -STANDARD_GRAVITY_M_S2 * math.sin(scene.incline_rad)
        direction = scene.incline_direction_rad
        q.set_slope(downhill * math.cos(direction), downhill * math.sin(direction))
    _torque(q, scene)
    if scene.servo is not None:
        q.servo = core_servo(scene.servo)
    faults = dict.fromkeys(scene.limp, _core.Fault.limp)
    faults |= dict.fromkeys(scene.locked, _core.Fault.locked)
    if faults:
        joints = range(1, scene.robot.links)
        q.faults = [faults.get(joint, _core.Fault.none) for joint in joints]
        q.locked_rad = [scene.locked.get(joint, 0.0) for joint in joints]
    q.method = scene.method
    q.most_steps = MAX_LINK_STEPS // scene.robot.links
    for name in RECORDS:
        setattr(q, f"record_{name}", name in scene.record)
    return q


def run_core(scene: Scene, start: LinkState, progress: Progress | None = None) -> dict[str, Any]:
    """Run a scene from a start and return Run's arrays by name (module.cpp); or raise Diverged."""
    columns = _core.run(core_request(scene), start.packed(), progress)
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
