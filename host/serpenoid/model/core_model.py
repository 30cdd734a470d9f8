"""Robot, ground and gait as the compiled core takes them."""

from __future__ import annotations

import warnings

from .. import _core
from ..base.checks import check_kind
from .gait import Gait
from .ground import Ground
from .robot import Robot
from .unit_doubts import unit_doubts


def check_parts(robot: Robot, ground: Ground, gait: Gait | None = None) -> None:
    """Raise BadInput unless robot, ground and (if any) gait came in this order.

    What looks like a number in another unit is warned of, once in a program.
    """
    order = "robot, ground, gait"
    check_kind("robot", robot, Robot, order=order)
    check_kind("ground", ground, Ground, order=order)
    if gait is not None:
        check_kind("gait", gait, Gait, order=order)
    for doubt in unit_doubts(robot, gait):
        warnings.warn(doubt, stacklevel=1)


def friction_numbers(ground: Ground) -> tuple[float, float, float, float, float, float]:
    """Return ct, cn, ft0, fn0, and what ct and ft0 are backwards, as the core takes them."""
    return (
        ground.ct_forward,
        ground.cn,
        ground.ft0_forward,
        ground.fn0,
        ground.ct_backward,
        ground.ft0_backward,
    )


def core_model(robot: Robot, ground: Ground, gait: Gait) -> _core.Model:
    """Hand the three to the compiled core (which counts length by halves, as the paper does)."""
    model = _core.Model(
        robot.links,
        robot.link_mass_kg,
        robot.link_length_m / 2,
        robot.inertia_kg_m2,
        *friction_numbers(ground),
        gait.alpha_rad,
        gait.beta_rad,
        gait.omega_rad_s,
        gait.offset_rad,
    )
    if gait.joint_gain or gait.joint_shift_rad:
        model.set_joints(*gait.joint_factors(robot.links - 1))
    return model
