"""The error of a run, by finer runs beside it; and the finer runs until a wanted error is met.

A run is compared with much finer ones, by another method where one runs the scene. The difference
to the finest is the run's error, even if its steps are too long to show an order; the difference
between the two finest checks that, and is added. Where it is not small, a finer run yet is tried;
else the figures are no bound: RunError.settled then says so, and chaos is named.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator
from contextlib import suppress
from dataclasses import replace

import numpy as np

from ..base.checks import check_choice, check_number
from ..base.errors import BadInput, Diverged, NotConverged, StepTooLarge
from ..base.vectors import Array
from .error import Difference, RunError
from .methods import METHODS, OwnChoice
from .run import ENERGY_COLUMNS, Run
from .scene import Scene, default_method, objection
from .stability import largest_stable_step_s, stability_test

Simulate = Callable[[Scene], Run]
_AGREE = 0.3  # of a run's error: by how much finer runs may differ
_WILD = 3.0  # body lengths and radians: beyond, runs are apart by chance
_TOO_LITTLE = 1e-3  # for the finest run to be far off, when it differs by no more from the finer
_BELIEVED = 0.01  # body lengths and radians
_CHAOS = 1e4  # times its tolerance: what a smooth motion of a few cycles does not make of it
_RESTS = 1e-4  # body lengths a period: a robot that goes less has no speed worth a share
_UNKNOWN = Difference(math.inf, math.inf, math.inf)
_TIGHT, _TIGHTEST = 1e-8, 1e-10  # of methods that pick their steps
_LEAST = 1e-13
_MOST_ACCURATE = ("dop853", "nonsmooth", "rk4")
_TRIES = 6
_MOST_LINK_STEPS = 10**8  # some ten seconds
KEEPABLE = ("dt_s", "tolerance")
_WHY = {
    "nonsmooth": "dry friction holds wheels: sticking must be exact",
    "dop853": "smooth motion, without springs that ring: high order at few steps",
    "radau": "stiff springs: steps as long as the slow motion allows",
}


def exact_scene(scene: Scene, tolerance: float) -> Scene:
    """Return a scene in the explicit formulation, by the most accurate method for it."""
    bare = replace(_bare(scene), formulation="explicit", method="auto")
    method = next(name for name in _MOST_ACCURATE if objection(name, bare) is None)
    return replace(bare, tolerance=tolerance, method=method)


def _bare(scene: Scene) -> Scene:
    """Return a scene that records what runs are compared by: energies at most."""
    return replace(scene, record=tuple(name for name in scene.record if name == "energy"))


def _ladders(scene: Scene) -> Iterator[list[Scene]]:
    """Yield scenes to hold a run against, finer and finer; another ladder if one gives up.

    A scene behind the second one is for runs on which those before do not agree.
    """
    bare, tolerance = _bare(scene), scene.tolerance
    if not scene.adaptive:
        if scene.formulation == "explicit":
            exact = exact_scene(bare, _TIGHT)
            if exact.adaptive:  # fixed steps take no notice of a tolerance
                yield _by_tolerance(exact, _TIGHT, _TIGHTEST)
        elif scene.law != "dry":
            for method in ("dop853", "radau"):
                if objection(method, bare) is None:
                    yield _by_tolerance(replace(bare, method=method), _TIGHT, _TIGHTEST)
        yield _by_step(bare)
        return
    tight, tightest = min(tolerance / 10, _TIGHT), min(tolerance / 1000, _TIGHTEST)
    if tightest < _LEAST:  # rounding is all that is left: looser runs tell as much
        tight, tightest = max(100 * tolerance, 1e-11), max(10 * tolerance, 1e-12)
    exact = exact_scene(bare, tight)
    if scene.formulation == "explicit" and exact.method != scene.method:
        yield _by_tolerance(exact, tight, tightest)
    if scene.method == "radau":  # of low order: each digit is dear
        tight, tightest = tolerance / 10, tolerance / 1000
    yield _by_tolerance(bare, tight, tightest)


def _by_tolerance(scene: Scene, tight: float, tightest: float) -> list[Scene]:
    """Return the scene at two tolerances, and in the exact model at one that is closer yet.

    Below some tolerance rounding errors make steps short and tell no more: a run by nonsmooth takes
    ten times as long at 1e-11 with 40 links, and forty times at 1e-10 with 99. On dry ground some
    runs at 1e-8 err by more than others at 1e-6: in a long run by a curve.
    """
    many = scene.method == "nonsmooth"
    least = _LEAST * max(1.0, (scene.robot.links / 3) ** 3) if many else _LEAST
    rungs = [max(tight, 10 * least), max(tightest, least)]
    if scene.formulation == "explicit" and rungs[-1] / 10 >= least:
        rungs.append(rungs[-1] / 10)
    return [replace(scene, tolerance=rung) for rung in rungs]


def _by_step(scene: Scene) -> list[Scene]:
    """Take the double step and the half one; the half and the quarter where double is unstable."""
    every, dt = scene.every, scene.dt_s
    stable = stability_test(scene)
    half, quarter = (replace(scene, dt_s=dt / k, record_every=k * every) for k in (2, 4))
    if every % 2 == 0 or every == 1:
        double = replace(scene, dt_s=2 * dt, record_every=max(every // 2, 1))
        if double.steps >= 4 and (stable is None or stable(double.dt_s)):
            return [double, half]
    return [half, quarter]


def _apart(run: Run, other: Run) -> tuple[Array, Array, Array, Array]:
    """Return the times that both recorded, and how far the runs are apart then.

    Links' centres at most, m, and angles, rad, (times,); energies, J, (times, columns) or empty.
    """
    t_s, a, b = np.intersect1d(run.t_s, other.t_s, return_indices=True)
    position = np.hypot(run.x_m[a] - other.x_m[b], run.y_m[a] - other.y_m[b])
    angle, energy = np.abs(run.theta_rad[a] - other.theta_rad[b]), np.empty(0)
    if run.energy_j.size and other.energy_j.size:
        energy = np.abs(run.energy_j[a] - other.energy_j[b])
    return t_s, position.max(axis=1), angle.max(axis=1), energy


def difference(run: Run, other: Run) -> Difference:
    """Return how far two runs are apart at the times that both recorded."""
    _, position, angle, energy = _apart(run, other)
    most = energy.max(axis=0).tolist() if energy.size else []
    ledger: dict[str, float] = dict(zip(ENERGY_COLUMNS, most, strict=False))
    share = _share_of_speed(run, other)
    return Difference(float(position.max()), float(angle.max()), share, ledger or None)


def _share_of_speed(run: Run, other: Run) -> float:
    """Return by what share of the other's mean speed a run's differs; nan where both rest."""
    if _rests(other):
        return math.nan if _rests(run) else math.inf
    return (run.travel_m - other.travel_m) / other.travel_m


def _rests(run: Run) -> bool:
    periods = run.t_s[-1] / run.scene.gait.period_s
    return bool(run.travel_m <= _RESTS * periods * run.scene.robot.body_length_m)


def _believed_s(run: Run, other: Run) -> float:
    """Return the time up to which two runs agree to a hundredth of a body length and radian."""
    t, position, angle, _ = _apart(run, other)
    body = run.scene.robot.body_length_m
    beyond = np.nonzero(np.maximum(position / body, angle) > _BELIEVED)[0]
    return float(t[-1] if beyond.size == 0 else t[max(beyond[0] - 1, 0)])


def _held_against(run: Run, finer: Run, finest: Run) -> RunError:
    """Return what two finer runs say of a run's error by its time steps."""
    body, one, other = run.scene.robot.body_length_m, finer.scene, finest.scene
    off, doubt = difference(run, finest), difference(finer, finest)
    error, rest = off.size(body), doubt.size(body)
    believed_s, chaotic = _believed_s(run, finest), False
    if one.adaptive:
        settled = rest <= max(_AGREE * min(error, _WILD), _TOO_LITTLE)
        parted = believed_s < run.t_s[-1]
        chaotic = not settled and parted and rest > _CHAOS * one.tolerance
        off = off.grown(by=doubt)
        word = f"by {one.method} at tolerance {one.tolerance:.3g} and {other.tolerance:.3g}"
    else:  # of order 1 the steps' errors are 2, 1, 1/2 or 1, 1/2, 1/4 of the run's
        coarser = one.dt_s > run.scene.dt_s
        settled = rest >= 1.5 * error - 1e-12 if coarser else rest <= 0.6 * error + 1e-12
        off = off.grown(2.0 if coarser else 4 / 3)
        word = f"at dt_s {one.dt_s:g} and {other.dt_s:g}"
    word = f"integration: difference to runs {word}"
    return RunError(off, None, word, settled, believed_s, chaotic)


def _integration(run: Run, simulate: Simulate) -> RunError:
    """Hold a run against finer ones until they agree, or are chaotic, or there are no others."""
    for first, *others in _ladders(run.scene):
        error = None
        with suppress(Diverged, StepTooLarge):
            finer = simulate(first)
            for scene in others:
                finest = simulate(scene)
                error = _held_against(run, finer, finest)
                if error.settled or error.chaotic:
                    break
                finer = finest
        if error is not None:
            return error
    word = "integration: no finer run comes to its end"
    return RunError(_UNKNOWN, None, word, False, 0.0)


def run_error(run: Run, simulate: Simulate) -> RunError:
    """Estimate the error of a run by two more runs, or three for the implicit formulation."""
    scene, error = run.scene, _integration(run, simulate)
    if scene.formulation == "explicit":
        return error
    exact = exact_scene(scene, min(scene.tolerance, 1e-6))
    word = f"modelling: difference to the explicit formulation by {exact.method}"
    springs = difference(run, simulate(exact))
    return replace(error, modelling=springs, how=f"{error.how}; {word}")


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
    smooth = () if scene.law == "dry" else ("radau", "dop853")
    runs = (method for method in smooth if objection(method, scene) is None)
    return next(runs, default_method(scene))


def _split(scene: Scene, parts: float) -> Scene:
    """Return a scene whose steps are shorter by at least a factor, its recorded times the same."""
    if parts <= 1:
        return scene
    whole = math.ceil(parts)
    return replace(scene, dt_s=scene.dt_s / whole, record_every=whole * scene.every)


def _finer(scene: Scene, factor: float) -> Scene:
    """Return a scene whose error should be smaller by a factor."""
    if scene.adaptive:
        return replace(scene, tolerance=max(scene.tolerance / factor / 3, _LEAST))
    order = 1 if scene.law == "dry" or scene.servo else METHODS[scene.method].order
    return _split(scene, max(2.0, 1.2 * factor ** (1 / order)))


def _stuck(run: Run, accuracy: float, keep: Collection[str]) -> str | None:
    """Return why no finer run may be tried, or None."""
    scene, error = run.scene, run.error_estimate
    springs = error.modelling and error.modelling.size(scene.robot.body_length_m)
    if springs and springs > max(accuracy, error.integration.size(scene.robot.body_length_m)):
        wanted = 1.5 * scene.joint_stiffness_n_m * springs / accuracy
        return (
            f"the springs alone (k = {scene.joint_stiffness_n_m:g} N/m) are as far off; take "
            f"formulation 'explicit', or joint_stiffness_n_m {wanted:.1g}"
        )
    if error.chaotic and not error.settled:
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


def simulate_to(accuracy: float, scene: Scene, simulate: Simulate, keep: Collection[str]) -> Run:
    """Return a run whose estimated error is at most `accuracy`, in body lengths and radians.

    The scene's formulation stays, and its method unless the scene chose it itself; so do fields
    that `keep` names, of KEEPABLE. dt_s stays the grid of recorded times: fixed steps are whole
    parts of it. Raises NotConverged, with the error that was reached and why.
    """
    tried, why = _first(scene, accuracy, keep)
    reason, worst = None, math.inf
    for _ in range(_TRIES):
        run = simulate(tried)
        error, step = run.error_estimate, f"dt_s {tried.dt_s:g}"
        worst = error.worst(tried.robot.body_length_m)
        if worst <= accuracy and error.settled:
            step = f"tolerance {tried.tolerance:g}" if tried.adaptive else step
            return run.picked_because(
                f"formulation {tried.formulation!r}, method {tried.method!r}, {step}: {why}; "
                f"estimated error {worst:.2g} of the {accuracy:g} asked for"
            )
        reason = _stuck(run, accuracy, keep)
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
