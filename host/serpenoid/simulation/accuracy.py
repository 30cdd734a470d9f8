"""Runs to a wanted accuracy: picks method and step where they are left open, and says why."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection
from dataclasses import replace

from ..model.checks import check_choice, check_number
from ..model.errors import BadInput, NotConverged
from .judge import exact_scene
from .methods import METHODS, OwnChoice
from .run import Run
from .scene import Scene, default_method, objection
from .stability import largest_stable_step_s

_TRIES = 6
_MOST_LINK_STEPS = 10**8  # some ten seconds
_LEAST_TOLERANCE = 1e-13
KEEPABLE = ("dt_s", "tolerance")
_WHY = {
    "collocation": "the joint angles are imposed and friction is viscous: three equations in the "
    "body frame, whose linear part is solved once a cycle",
    "nonsmooth": "dry friction holds wheels: sticking must be exact",
    "dop853": "smooth motion, without springs that ring: high order at few steps",
    "radau": "stiff springs: steps as long as the slow motion allows",
}


def _first(scene: Scene, accuracy: float, keep: Collection[str]) -> tuple[Scene, str]:
    """Return the scene with what is left open chosen, and why so."""
    tight = max(accuracy / 10, 1e-12)
    chosen, why = scene, f"method {scene.method!r} was given"
    if isinstance(scene.method, OwnChoice):
        method = _method(scene)
        chosen, why = replace(scene, method=method), _WHY.get(method, "the scene's own method")
    if "tolerance" not in keep:
        chosen = replace(chosen, tolerance=tight)
    if "dt_s" not in keep and not chosen.adaptive:
        most_s = min(chosen.gait.period_s / 40, largest_stable_step_s(chosen) / 2)
        chosen = _split(chosen, chosen.dt_s / most_s)
    return chosen, why


def _method(scene: Scene) -> str:
    """Return the method that gets a scene most accurate, of those that record what it asks."""
    if scene.formulation == "explicit":
        return exact_scene(scene, scene.tolerance).method
    if scene.law == "dry":
        return default_method(scene)
    return "dop853" if objection("radau", scene) else "radau"


def _split(scene: Scene, parts: float) -> Scene:
    """Return a scene whose steps are shorter by at least a factor, its recorded times the same."""
    if parts <= 1:
        return scene
    whole = math.ceil(parts)
    return replace(scene, dt_s=scene.dt_s / whole, record_every=whole * scene.every)


def _finer(scene: Scene, factor: float) -> Scene:
    """Return a scene whose error should be smaller by a factor."""
    if scene.adaptive:
        return replace(scene, tolerance=max(scene.tolerance / factor / 3, _LEAST_TOLERANCE))
    order = 1 if scene.law == "dry" or scene.servo else METHODS[scene.method].order
    return _split(scene, max(2.0, 1.2 * factor ** (1 / order)))


def _stuck(scene: Scene, run: Run, accuracy: float, keep: Collection[str]) -> str | None:
    """Return why no finer run may be tried, or None."""
    error, body = run.error_estimate, scene.robot.body_length_m
    if error.modelling and error.modelling.size(body) > max(accuracy, error.integration.size(body)):
        wanted = 1.5 * scene.joint_stiffness_n_m * error.modelling.size(body) / accuracy
        return (
            f"the springs alone (k = {scene.joint_stiffness_n_m:g} N/m) are as far off; take "
            f"formulation 'explicit', or joint_stiffness_n_m {wanted:.1g}"
        )
    if not error.settled and error.chaotic:
        return f"the motion is chaotic; believe it up to t = {error.believed_s:.3g} s"
    field = "tolerance" if scene.adaptive else "dt_s"
    if field in keep:
        return f"{field} {getattr(scene, field):g} was given; take a smaller one, or leave it open"
    return None


def check_wanted(accuracy: float, keep: Collection[str]) -> None:
    """Raise BadInput for an accuracy that no run has, or for fields that cannot be kept."""
    check_number("accuracy", accuracy, 1e-10, 0.1)
    for name in keep:
        check_choice("keep", name, KEEPABLE)


def simulate_to(
    accuracy: float, scene: Scene, simulate: Callable[[Scene], Run], keep: Collection[str]
) -> Run:
    """Return a run whose estimated error is at most `accuracy`, in body lengths and radians.

    The scene's formulation stays, and its method unless the scene chose it itself; so do fields
    that `keep` names, of KEEPABLE. dt_s stays the grid of recorded times: fixed steps are whole
    parts of it. Raises NotConverged, with the error that was reached and why.
    """
    tried, why = _first(scene, accuracy, keep)
    reason = None
    worst = math.inf
    for _ in range(_TRIES):
        run = simulate(tried)
        worst = run.error_estimate.worst(tried.robot.body_length_m)
        if worst <= accuracy and run.error_estimate.settled:
            step = f"tolerance {tried.tolerance:g}" if tried.adaptive else f"dt_s {tried.dt_s:g}"
            return run.picked_because(
                f"formulation {tried.formulation!r}, method {tried.method!r}, {step}: {why}; "
                f"estimated error {worst:.2g} of the {accuracy:g} asked for"
            )
        reason = _stuck(tried, run, accuracy, keep)
        if reason is not None:
            break
        try:
            tried = _finer(tried, min(max(worst / accuracy, 1.0), 1e3))
        except BadInput:  # more steps than any run may have
            break
        if not tried.adaptive and tried.steps * scene.robot.links > _MOST_LINK_STEPS:
            reason = f"its steps would have to be {tried.dt_s:.1g} s; leave the method open"
            break
    raise NotConverged(
        f"accuracy is {accuracy:g}; method {tried.method!r} came to {worst:.2g} only: "
        + (reason or "ask for less, or a shorter run")
    )
