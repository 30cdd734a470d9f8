"""Scenes beside a scene: its exact model, stiffer springs, and the longest step it allows."""

from __future__ import annotations

import math
from dataclasses import replace

from .scene import Scene
from .stability import largest_step_s, stability_test


def plain(scene: Scene) -> bool:
    """Tell whether all joints follow the gait, on the level."""
    return follows_gait(scene) and not scene.incline_rad


def follows_gait(scene: Scene) -> bool:
    """Tell whether all joints follow the gait."""
    return scene.drive == "angle" and not (scene.limp or scene.locked)


def exact_scene(scene: Scene, tolerance: float) -> Scene | None:
    """Return a scene in the explicit formulation, by the best method for it; None if none is good.

    (Dry friction needs exact sticking; the explicit formulation has it if all joints follow the
    gait.)
    """
    if scene.law == "dry":
        method = "nonsmooth"
        if not follows_gait(scene) or scene.gait.alpha_rad == scene.gait.offset_rad == 0:
            return None
    else:
        method = "collocation" if plain(scene) and scene.law == "viscous" else "dop853"
    return replace(scene, formulation="explicit", tolerance=tolerance, record=(), method=method)


def stiffer_scene(scene: Scene, factor: float) -> Scene:
    """Return an implicit scene with springs and dampers stiffer by a factor, at a stable step."""
    scene = replace(
        scene, record=(), joint_stiffness_n_m=factor * scene.joint_stiffness_n_m,
        joint_damping_n_s_m=factor * scene.joint_damping_n_s_m,
    )  # fmt: skip
    limit = largest_stable_step_s(scene) / 2
    if scene.adaptive or scene.dt_s <= limit:
        return scene
    split = math.ceil(scene.dt_s / limit)
    return replace(scene, dt_s=scene.dt_s / split, record_every=split * scene.every)


def largest_stable_step_s(scene: Scene) -> float:
    """Return the largest stable fixed step of a scene, s, at most its gait's period / 20."""
    most = scene.gait.period_s / 20
    stable = stability_test(scene)
    if stable is None or stable(most):
        return most
    return largest_step_s(stable, most)
