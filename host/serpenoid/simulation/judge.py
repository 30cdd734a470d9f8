"""The error of a run: two finer runs beside it, and the exact model beside the springs.

A run is compared with a much finer one, by another method where one runs the scene. Their
difference is the run's error, even if its steps are too long to show an order. A third run
between the two checks the finest, and their difference is added. Where that is not small, a finer
run yet is tried; else the figures are no bound: RunError.settled then says so, and chaos is named.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..model.errors import Diverged, StepTooLarge
from .error import Difference, RunError
from .run import ENERGY_COLUMNS, Run
from .scene import Scene, objection
from .stability import stability_test

Array = NDArray[np.float64]
_AGREE = 0.3  # of a run's error: by how much finer runs may differ
_WILD = 3.0  # body lengths and radians: beyond, runs are apart by chance
_TOO_LITTLE = 1e-3  # for the finest run to be far off, when it differs by no more from the finer
_BELIEVED = 0.01  # body lengths and radians
_CHAOS = 1e4  # times its tolerance: what a smooth motion of a few cycles does not make of it
_RESTS = 1e-4  # body lengths a period: a robot that goes less has no speed worth a share
_UNKNOWN = Difference(math.inf, math.inf, math.inf)
_TIGHT, _TIGHTEST = 1e-8, 1e-10  # of methods that pick their steps
_LEAST = 1e-13
_MOST_ACCURATE = ("collocation", "dop853", "nonsmooth", "rk4")


def exact_scene(scene: Scene, tolerance: float) -> Scene:
    """Return a scene in the explicit formulation, by the most accurate method for it."""
    bare = replace(scene, formulation="explicit", record=_ledger(scene), method="auto")
    method = next(name for name in _MOST_ACCURATE if objection(name, bare) is None)
    return replace(bare, tolerance=tolerance, method=method)


def _ledger(scene: Scene) -> tuple[str, ...]:
    """Return what another run must record to be compared with one: energies, or nothing."""
    return tuple(one for one in scene.record if one == "energy")


@dataclass(frozen=True, slots=True)
class FinerScenes:
    """Hold a scene that is finer than another, and one that is finer still.

    near: error of `finer` that its settings promise, in body lengths and radians; 0: no promise.
    coarser: whether `finer` is coarser than the run, for want of time.
    """

    finer: Scene
    finest: Scene
    near: float
    word: str
    coarser: bool = False


def finer_scenes(scene: Scene) -> Iterator[FinerScenes]:
    """Yield pairs of scenes to hold a run against, the best first; a later one if one gives up.

    A pair that begins with the last one's finest scene is for runs on which those do not agree.
    """
    bare = replace(scene, record=_ledger(scene))
    if scene.adaptive:
        yield from _by_tolerance(bare, scene.tolerance)
        return
    if scene.formulation == "explicit":
        yield from _with_closer(_pair(exact_scene(bare, _TIGHT), _TIGHT, _TIGHTEST))
    elif scene.law != "dry":
        yield _pair(replace(bare, method="dop853"), _TIGHT, _TIGHTEST)
        if not (scene.limp or scene.locked):
            yield _pair(replace(bare, method="radau"), _TIGHT, _TIGHTEST)
    yield _by_step(bare)


def _least_tolerance(scene: Scene) -> float:
    """Return the tolerance below which rounding errors make steps short and tell no more.

    A run by nonsmooth takes ten times as long at 1e-11 with 40 links, and forty times at 1e-10 with
    99.
    """
    if scene.method != "nonsmooth":
        return _LEAST
    return _LEAST * max(1.0, (scene.robot.links / 3) ** 3)


def _pair(scene: Scene, tight: float, tightest: float) -> FinerScenes:
    if scene.method == "nonsmooth":
        least = _least_tolerance(scene)
        tight, tightest = max(tight, 10 * least), max(tightest, least)
    return FinerScenes(
        replace(scene, tolerance=tight),
        replace(scene, tolerance=tightest),
        tight,
        f"runs by {scene.method} at tolerance {tight:.3g} and {tightest:.3g}",
    )


def _with_closer(pair: FinerScenes) -> Iterator[FinerScenes]:
    """Yield a pair of the exact model, and for runs on which it does not agree its finest and one
    that is ten times closer.

    On dry ground some runs at 1e-8 err by more than others at 1e-6: in a long run by a curve.
    """
    yield pair
    scene, tight = pair.finest, pair.finest.tolerance
    if scene.formulation == "explicit" and tight / 10 >= _least_tolerance(scene):
        yield replace(_pair(scene, tight, tight / 10), finer=scene)


def _by_tolerance(scene: Scene, tolerance: float) -> Iterator[FinerScenes]:
    """Take another method where one is exact, and tolerances whose errors do not matter."""
    tight, tightest = min(tolerance / 10, _TIGHT), min(tolerance / 1000, _TIGHTEST)
    if tightest < _LEAST:  # rounding is all that is left: looser runs tell as much
        tight, tightest = max(100 * tolerance, 1e-11), max(10 * tolerance, 1e-12)
    exact = exact_scene(scene, tight)
    if scene.formulation == "explicit" and exact.method != scene.method:
        yield from _with_closer(_pair(exact, tight, tightest))
    if scene.method == "radau":  # of low order: each digit is dear
        tight, tightest = max(tolerance / 10, 10 * _LEAST), max(tolerance / 1000, _LEAST)
    yield from _with_closer(_pair(scene, tight, tightest))


def _by_step(scene: Scene) -> FinerScenes:
    """Take the double step and the half one; the half and the quarter where double is unstable."""

    def at(dt_s: float, every: int) -> Scene:
        return replace(scene, dt_s=dt_s, record_every=every)

    every, dt = scene.every, scene.dt_s
    stable = stability_test(scene)
    half = at(dt / 2, 2 * every)
    if every % 2 == 0 or every == 1:
        double = at(2 * dt, max(every // 2, 1))
        if double.steps >= 4 and (stable is None or stable(double.dt_s)):
            word = f"runs at dt_s {2 * dt:g} and {dt / 2:g}"
            return FinerScenes(double, half, 0.0, word, coarser=True)
    quarter = at(dt / 4, 4 * every)
    return FinerScenes(half, quarter, 0.0, f"runs at dt_s {dt / 2:g} and {dt / 4:g}")


def _apart(run: Run, other: Run) -> tuple[Array, Array, Array, Array]:
    """Return the times that both recorded, and how far the runs are apart then.

    Links' centres at most, m, and angles, rad, (times,); energies, J, (times, columns) or empty.
    """
    after = np.searchsorted(other.t_s, run.t_s - 1e-9 * run.t_s[-1])
    after = np.minimum(after, other.t_s.size - 1)
    both = np.abs(other.t_s[after] - run.t_s) <= 1e-9 * max(run.t_s[-1], 1e-300)
    a, b = np.nonzero(both)[0], after[both]
    position = np.hypot(run.x_m[a] - other.x_m[b], run.y_m[a] - other.y_m[b])
    angle, energy = np.abs(run.theta_rad[a] - other.theta_rad[b]), np.empty(0)
    if run.energy_j.size and other.energy_j.size:
        energy = np.abs(run.energy_j[a] - other.energy_j[b])
    return run.t_s[a], position.max(axis=1), angle.max(axis=1), energy


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


def _held_against(run: Run, finer: Run, finest: Run, how: FinerScenes) -> RunError:
    """Return what two finer runs say of a run's error by its time steps."""
    body = run.scene.robot.body_length_m
    off, doubt = difference(run, finest), difference(finer, finest)
    error, rest = off.size(body), doubt.size(body)
    believed_s, chaotic = _believed_s(run, finest), False
    if how.near > 0:
        settled = rest <= max(_AGREE * min(error, _WILD), _TOO_LITTLE)
        parted = believed_s < run.t_s[-1]
        chaotic = not settled and parted and rest > _CHAOS * how.near
        off = off.beside(doubt)
    else:  # of order 1 the steps' errors are 2, 1, 1/2 or 1, 1/2, 1/4 of the run's
        settled = rest >= 1.5 * error - 1e-12 if how.coarser else rest <= 0.6 * error + 1e-12
        off = off.scaled(2.0 if how.coarser else 4 / 3)
    word = f"integration: difference to {how.word}"
    return RunError(off, None, word, settled, believed_s, chaotic)


def _integration(run: Run, simulate: Callable[[Scene], Run]) -> RunError:
    """Hold a run against finer ones until they agree, or are chaotic, or there are no others."""
    error, finest = None, None
    for how in finer_scenes(run.scene):
        known = finest if finest is not None and finest.scene is how.finer else None
        if error is not None and known is None:
            break  # a pair for want of the one before
        try:
            finer = known or simulate(how.finer)
            finest = simulate(how.finest)
        except (Diverged, StepTooLarge):
            continue
        error = _held_against(run, finer, finest, how)
        if error.settled or error.chaotic:
            break
    word = "integration: no finer run comes to its end"
    return error or RunError(_UNKNOWN, None, word, False, 0.0)


def run_error(run: Run, simulate: Callable[[Scene], Run]) -> RunError:
    """Estimate the error of a run by two more runs, or three for the implicit formulation."""
    scene, error = run.scene, _integration(run, simulate)
    if scene.formulation == "explicit":
        return error
    exact = exact_scene(scene, min(scene.tolerance, 1e-6))
    word = f"modelling: difference to the explicit formulation by {exact.method}"
    springs = difference(run, simulate(exact))
    return replace(error, modelling=springs, how=f"{error.how}; {word}")
