"""Estimate the error of a run by a finer one; find the step or tolerance that an accuracy needs.

A finer run has half the step, or a tenth of the tolerance (nonsmooth: a hundredth). The estimate is
four times the difference. The error of a method of order 1 is twice the difference, that of higher
orders less. Where dry friction is not resolved, or over many cycles, this ratio varies; with 4, the
error of 99 % of random scenes is below the estimate.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace

from ..base.errors import Diverged, NotConverged, StepTooLarge
from .run import Difference, Run, RunError, chatters, difference
from .scene import MIN_TOLERANCE, OwnChoice, Scene, exact_scene, most_accurate_method
from .stability import largest_stable_step_s

SAFETY = 4.0  # estimated error over the difference from the finer run
REASONS = {
    "nonsmooth": "dry friction holds wheels: sticking must be exact",
    "dop853": "smooth motion, without springs that ring: high order at few steps",
    "radau": "stiff springs: steps as long as the slow motion allows",
}
Solve = Callable[..., Run]  # function of a scene, and of a start in place of the scene's


def estimated_error(run: Run, solve: Solve) -> RunError:
    """Return the error of a run, estimated by one finer run or two."""
    start, scene, body_m = run.state(0), run.scene, run.scene.robot.body_length_m
    finer = finer_scene(scene)
    unknown = Difference(math.inf, math.inf, math.inf)
    error = RunError(unknown, None, "no finer run comes to its end", False)
    with suppress(Diverged, StepTooLarge):
        second = solve(finer, start)
        (largest, believed_s), settled = difference(run, second, SAFETY), True
        # A third run checks a difference above a thousandth of the body and of a radian. It checks
        # any difference of a method without exact sticking, because its error falls unevenly.
        if largest.size(body_m) > SAFETY / 1000 or chatters(scene):
            third = solve(finer_scene(scene, 2), start)
            change, _ = difference(second, third, SAFETY)
            # Runs of order 1 converge if the next difference is at most 0.75 of this one.
            settled = change.size(body_m) <= 0.75 * largest.size(body_m)
            largest = max(largest, change, key=lambda part: part.size(body_m))
        how = f"integration: {SAFETY:g} times the difference to a run at {_setting(finer)}"
        error = RunError(largest, None, how, settled, believed_s)
    if scene.formulation == "explicit":
        return error
    exact = exact_scene(scene, min(scene.tolerance, 1e-6))
    how = f"{error.how}; modelling: difference to the explicit formulation by {exact.method}"
    modelling, _ = difference(run, solve(exact))
    return replace(error, modelling=modelling, how=how)


def accurate_run(scene: Scene, accuracy: float, solve: Solve, max_link_steps: int = 10**8) -> Run:
    """Return a run whose estimated error is at most the accuracy; or raise NotConverged.

    max_link_steps: links times fixed steps of a run that takes some ten seconds.
    """
    (tried, why), body_m, worst = _first_try(scene, accuracy), scene.robot.body_length_m, math.inf
    reason = "ask for less, or a shorter run"
    for _ in range(12):
        if not tried.adaptive and tried.steps * scene.robot.links > max_link_steps:
            reason = f"its steps would have to be {tried.dt_s:.1g} s; leave the method out"
            break
        picked = f"formulation {tried.formulation!r}, method {tried.method!r}, {_setting(tried)}"
        run = solve(tried, picked=f"{picked}: {why}")
        error = run.error_estimate
        worst = error.worst(body_m)
        if worst <= accuracy and error.settled:
            return run
        modelling = error.modelling.size(body_m) if error.modelling else 0.0
        if modelling > max(accuracy, error.integration.size(body_m)):
            stiffness_n_m = 1.5 * scene.joint_stiffness_n_m * modelling / accuracy
            reason = (
                f"the springs alone (k = {scene.joint_stiffness_n_m:g} N/m) cause that error; take "
                f"formulation 'explicit', or joint_stiffness_n_m {stiffness_n_m:.1g}"
            )
            break
        if not error.settled:
            reason = f"finer runs do not agree; believe it up to t = {error.believed_s:.3g} s"
        finer = replace(tried, tolerance=max(tried.tolerance / 30, MIN_TOLERANCE))
        tried = finer if tried.adaptive else with_shorter_steps(tried, 4)
    raise NotConverged(
        f"accuracy is {accuracy:g}; method {tried.method!r} reached only {worst:.2g}: {reason}"
    )


def _setting(scene: Scene) -> str:
    name = "tolerance" if scene.adaptive else "dt_s"
    return f"{name} {getattr(scene, name):.3g}"


def _first_try(scene: Scene, accuracy: float) -> tuple[Scene, str]:
    """Return the scene of the first run, with its method and step or tolerance, and the reason."""
    first_scene, why = scene, f"method {scene.method!r} was given"
    if isinstance(scene.method, OwnChoice):
        method = most_accurate_method(scene)
        first_scene, why = replace(scene, method=method), REASONS[method]
    first_scene = replace(first_scene, tolerance=max(accuracy / 10, 10 * MIN_TOLERANCE))
    if first_scene.adaptive:
        return first_scene, why
    longest_s = min(first_scene.gait.period_s / 40, largest_stable_step_s(first_scene) / 2)
    return with_shorter_steps(first_scene, first_scene.dt_s / longest_s), why


def finer_scene(scene: Scene, times: int = 1) -> Scene:
    """Return the scene with its tolerance divided by ten, or its step by two, `times` times.

    For nonsmooth the tolerance is divided by a hundred: steps begin anew after each event, so that
    runs at similar tolerances often take the same steps and share their error. Below some tolerance
    rounding only makes steps shorter (a run by nonsmooth takes ten times as long at 1e-11 with 40
    links). There the tolerance is multiplied by ten instead: the difference from the coarser run is
    larger than the error, and so still bounds it.
    """
    if not scene.adaptive:
        return with_shorter_steps(scene, 2**times)
    events = scene.method == "nonsmooth"
    finest = MIN_TOLERANCE * (max(1.0, (scene.robot.links / 3) ** 3) if events else 1.0)
    finer = scene.tolerance / (100.0 if events else 10.0) ** times
    coarser = scene.tolerance * 10.0**times
    return replace(scene, tolerance=finer if finer >= finest else coarser)


def with_shorter_steps(scene: Scene, parts: float) -> Scene:
    """Return the scene with steps at least `parts` times shorter, and the same recorded times."""
    count = max(math.ceil(parts), 1)
    return replace(scene, dt_s=scene.dt_s / count, record_every=count * scene.record_steps)
