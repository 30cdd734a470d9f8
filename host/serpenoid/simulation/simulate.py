"""A run in time, of a scene as it is, or with the step or tolerance that an accuracy needs.

Its error is estimated by a finer run, with half the step, or a tenth of the tolerance (nonsmooth: a
hundredth). Four times the difference is the estimate. Of a method of order 1 the error is twice the
difference, of higher orders less. Where dry friction is not resolved, or over many cycles, it
varies: 4 keeps 99 % of random scenes within it.
"""

from __future__ import annotations

import math
from contextlib import suppress
from dataclasses import replace

from ..base.checks import check_kind, check_number
from ..base.errors import Diverged, NotConverged, StepTooLarge
from ..model.link_state import LinkState
from .core_run import Progress, run_core, start_state
from .run import Difference, Run, RunError, chatters, difference
from .scene import METHODS, MIN_TOLERANCE, OwnChoice, Scene, exact_scene, most_accurate_method
from .stability import check_step, largest_stable_step_s

SAFETY = 4.0  # estimated error over the difference from the finer run
# Difference in body lengths and radians beyond which a third run checks it; so it does any
# difference of a method that does not know sticking, because its error falls unevenly.
CHECKED_SIZE = 1e-3
MAX_ACCURATE_STEPS = 10**8  # links times steps of a run with an accuracy: some ten seconds
REASONS = {
    "nonsmooth": "dry friction holds wheels: sticking must be exact",
    "dop853": "smooth motion, without springs that ring: high order at few steps",
    "radau": "stiff springs: steps as long as the slow motion allows",
}


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
        return _solved(scene, start_state(scene), progress)
    check_number("accuracy", accuracy, 1e-10, 0.1)
    return _accurate_run(scene, accuracy, progress)


def _solved(
    scene: Scene, start: LinkState, progress: Progress | None = None, picked: str = ""
) -> Run:
    """Run a scene from a start; raises StepTooLarge and Diverged."""
    check_step(scene)
    columns = run_core(scene, start, progress)
    return Run(scene=scene, picked=picked, _estimator=_estimate, **columns)


def _estimate(run: Run) -> RunError:
    """Return the error of a run by one finer run, or two."""
    start, scene, body_m = run.state(0), run.scene, run.scene.robot.body_length_m
    finer = finer_scene(scene)
    setting = "tolerance" if scene.adaptive else "dt_s"
    unknown = Difference(math.inf, math.inf, math.inf)
    error = RunError(unknown, None, "no finer run comes to its end", False)
    with suppress(Diverged, StepTooLarge):
        second = _solved(finer, start)
        (largest, believed_s), settled = difference(run, second, SAFETY), True
        if largest.size(body_m) > SAFETY * CHECKED_SIZE or chatters(scene):
            third = _solved(finer_scene(scene, 2), start)
            change, _ = difference(second, third, SAFETY)
            # Runs of order 1 converge if the next difference is at most 0.75 of this one.
            settled = change.size(body_m) <= 0.75 * largest.size(body_m)
            largest = max(largest, change, key=lambda part: part.size(body_m))
        how = f"{SAFETY:g} times the difference to a run at {setting} {getattr(finer, setting):.3g}"
        error = RunError(largest, None, f"integration: {how}", settled, believed_s)
    if scene.formulation == "explicit":
        return error
    exact = exact_scene(scene, min(scene.tolerance, 1e-6))
    how = f"{error.how}; modelling: difference to the explicit formulation by {exact.method}"
    springs, _ = difference(run, _solved(exact, start_state(exact)))
    return replace(error, modelling=springs, how=how)


def _accurate_run(scene: Scene, accuracy: float, progress: Progress | None) -> Run:
    """Return a run whose estimated error is at most the accuracy; or raise NotConverged."""
    start, (tried, why) = start_state(scene), _first_try(scene, accuracy)
    worst, reason = math.inf, "ask for less, or a shorter run"
    for _ in range(6):
        setting = f"tolerance {tried.tolerance:g}" if tried.adaptive else f"dt_s {tried.dt_s:g}"
        picked = f"formulation {tried.formulation!r}, method {tried.method!r}, {setting}: {why}"
        run = _solved(tried, start, progress, picked)
        error, body_m = run.error_estimate, scene.robot.body_length_m
        worst = error.worst(body_m)
        if worst <= accuracy and error.settled:
            return run
        springs = error.modelling.size(body_m) if error.modelling else 0.0
        if springs > max(accuracy, error.integration.size(body_m)):
            stiffness_n_m = 1.5 * scene.joint_stiffness_n_m * springs / accuracy
            reason = (
                f"the springs alone (k = {scene.joint_stiffness_n_m:g} N/m) are as far off; take "
                f"formulation 'explicit', or joint_stiffness_n_m {stiffness_n_m:.1g}"
            )
            break
        if not error.settled:
            reason = f"finer runs do not agree; believe it up to t = {error.believed_s:.3g} s"
        tried = _finer(tried, min(max(worst / accuracy, 1.0), 1e2))
        if not tried.adaptive and tried.steps * scene.robot.links > MAX_ACCURATE_STEPS:
            reason = f"its steps would have to be {tried.dt_s:.1g} s; leave the method open"
            break
    raise NotConverged(
        f"accuracy is {accuracy:g}; method {tried.method!r} came to {worst:.2g} only: {reason}"
    )


def _first_try(scene: Scene, accuracy: float) -> tuple[Scene, str]:
    """Return the scene with the method and the step or tolerance to begin with, and why so."""
    chosen, why = scene, f"method {scene.method!r} was given"
    if isinstance(scene.method, OwnChoice):
        method = most_accurate_method(scene)
        chosen, why = replace(scene, method=method), REASONS[method]
    chosen = replace(chosen, tolerance=max(accuracy / 10, 10 * MIN_TOLERANCE))
    if chosen.adaptive:
        return chosen, why
    longest_s = min(chosen.gait.period_s / 40, largest_stable_step_s(chosen) / 2)
    return with_shorter_steps(chosen, chosen.dt_s / longest_s), why


def _finer(scene: Scene, factor: float) -> Scene:
    """Return a scene whose error should be smaller by a factor."""
    if scene.adaptive:
        return replace(scene, tolerance=max(scene.tolerance / factor / 3, MIN_TOLERANCE))
    order = 1 if scene.law == "dry" or scene.servo else METHODS[scene.method].order
    return with_shorter_steps(scene, max(2.0, 1.2 * factor ** (1 / order)))


def finer_scene(scene: Scene, times: int = 1) -> Scene:
    """Return the scene at a tenth of its tolerance or half its step, so many times.

    By nonsmooth it is a hundredth: after each event steps begin anew, so that runs at tolerances
    next to each other often take the same steps, and share their error. It records energies at
    most. Below some tolerance rounding makes steps short and tells no more
    (a run by nonsmooth takes ten times as long at 1e-11 with 40 links): there it is ten times the
    tolerance, whose difference is the larger.
    """
    scene = replace(scene, record=tuple(name for name in scene.record if name == "energy"))
    if not scene.adaptive:
        return with_shorter_steps(scene, 2**times)
    events = scene.method == "nonsmooth"
    finest = MIN_TOLERANCE * (max(1.0, (scene.robot.links / 3) ** 3) if events else 1.0)
    finer = scene.tolerance / (100.0 if events else 10.0) ** times
    coarser = scene.tolerance * 10.0**times
    return replace(scene, tolerance=finer if finer >= finest else coarser)


def with_shorter_steps(scene: Scene, parts: float) -> Scene:
    """Return a scene whose steps are shorter by at least a factor, its recorded times the same."""
    count = max(math.ceil(parts), 1)
    return replace(scene, dt_s=scene.dt_s / count, record_every=count * scene.record_steps)
