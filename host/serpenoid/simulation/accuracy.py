"""Runs to a wanted accuracy: picks formulation, method and step, and says which and why."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

from ..model.checks import check_number
from ..model.errors import NotConverged
from .related_scenes import exact_scene, largest_stable_step_s, stiffer_scene
from .run import Run
from .scene import Scene

_TRIES = 6
_MOST_LINK_STEPS = 10**8  # some ten seconds
_WHY = {
    "collocation": "the joint angles are imposed and friction is viscous: three equations in the "
    "body frame, whose linear part is solved once a cycle",
    "nonsmooth": "dry friction holds wheels: sticking must be exact",
    "dop853": "smooth motion, without springs: high order at few steps",
}


def _first(scene: Scene, accuracy: float) -> tuple[Scene, str]:
    """Return the scene with a formulation and a method, and why these."""
    exact = exact_scene(scene, max(accuracy / 10, 1e-12))
    if exact is not None:
        return replace(exact, record=scene.record), _WHY[exact.method]
    stiff = 1e5 * scene.robot.link_mass_kg
    soft = replace(
        scene, formulation="implicit", method="nonsmooth", joint_stiffness_n_m=stiff,
        joint_damping_n_s_m=1e-4 * stiff,
    )  # fmt: skip
    step = min(largest_stable_step_s(soft) / 2, scene.dt_s)
    return replace(soft, dt_s=step), "dry friction with this drive: springs, and exact sticking"


def _finer(scene: Scene, run: Run, factor: float) -> Scene:
    """Return a scene whose error should be smaller by a factor."""
    if scene.adaptive:
        return replace(scene, tolerance=max(scene.tolerance / factor / 3, 1e-13))
    error = run.error_estimate
    if error.modelling and error.modelling.position_m > error.integration.position_m:
        return replace(stiffer_scene(scene, 2 * factor), record=scene.record)
    return replace(scene, dt_s=scene.dt_s / max(2.0, 1.5 * factor))


def simulate_to(accuracy: float, scene: Scene, simulate: Callable[[Scene], Run]) -> Run:
    """Return a run whose estimated error is at most `accuracy`, in body lengths and radians.

    The scene's own formulation, method, step and tolerance give way. Raises NotConverged, with the
    error that was reached, when six refinements are not enough.
    """
    check_number("accuracy", accuracy, 1e-10, 0.1)
    body = scene.robot.links * scene.robot.link_length_m
    tried, why = _first(scene, accuracy)
    worst = math.inf
    for _ in range(_TRIES):
        run = simulate(tried)
        worst = run.error_estimate.worst(body)
        if worst <= accuracy:
            step = f"tolerance {tried.tolerance:g}" if tried.adaptive else f"dt_s {tried.dt_s:g}"
            picked = (
                f"formulation {tried.formulation!r}, method {tried.method!r}, {step}: {why}; "
                f"estimated error {worst:.2g} of the {accuracy:g} asked for"
            )
            return run.picked_because(picked)
        tried = _finer(tried, run, min(worst / accuracy, 1e3))
        if not tried.adaptive and tried.steps * scene.robot.links > _MOST_LINK_STEPS:
            break
    raise NotConverged(
        f"accuracy is {accuracy:g}; method {tried.method!r} came to {worst:.2g} only; ask for "
        "less, a shorter run, or choose method and step yourself"
    )
