"""Runs to a wanted accuracy: picks formulation, method and step, and says which and why."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

from ..model.checks import check_number
from ..model.errors import NotConverged
from .related_scenes import exact_scene
from .run import Run
from .scene import Scene

_TRIES = 6
_WHY = {
    "collocation": "the joint angles are imposed and friction is viscous: three equations in the "
    "body frame, whose linear part is solved once a cycle",
    "nonsmooth": "dry friction holds wheels: sticking must be exact",
    "dop853": "smooth motion, without springs: high order at few steps",
}


def _first(scene: Scene, accuracy: float) -> tuple[Scene, str]:
    """Return the scene with a formulation and a method, and why these."""
    exact = exact_scene(scene, max(accuracy / 10, 1e-12))
    return replace(exact, record=scene.record), _WHY[exact.method]


def _finer(scene: Scene, factor: float) -> Scene:
    """Return a scene whose error should be smaller by a factor."""
    return replace(scene, tolerance=max(scene.tolerance / factor / 3, 1e-13))


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
        if worst <= accuracy and run.error_estimate.settled:
            picked = (
                f"formulation {tried.formulation!r}, method {tried.method!r}, "
                f"tolerance {tried.tolerance:g}: {why}; "
                f"estimated error {worst:.2g} of the {accuracy:g} asked for"
            )
            return run.picked_because(picked)
        tried = _finer(tried, min(max(worst / accuracy, 1.0), 1e3))
    raise NotConverged(
        f"accuracy is {accuracy:g}; method {tried.method!r} came to {worst:.2g} only; ask for "
        "less, a shorter run, or choose method and step yourself"
    )
