"""Scenes beside a scene: its exact model, and finer ones that tell its error."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from .scene import Scene, objection
from .stability import stability_test

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

    factor: of the difference to the finest, for what the finest itself still errs by. near: error
    of `finer` that its settings promise, in body lengths and radians; 0: no promise. coarser:
    whether `finer` is the coarser, for want of time.
    """

    finer: Scene
    finest: Scene
    factor: float
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
        1.0,
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
            return FinerScenes(double, half, 2.0, 0.0, word, coarser=True)
    quarter = at(dt / 4, 4 * every)
    return FinerScenes(half, quarter, 4 / 3, 0.0, f"runs at dt_s {dt / 2:g} and {dt / 4:g}")
