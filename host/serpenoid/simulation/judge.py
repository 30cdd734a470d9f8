"""The error of a run: two finer runs beside it, and the exact model beside the springs.

A run is compared with a much finer one, by another method where one runs the scene. Their
difference is the run's error, even if its steps are too long to show an order. A third run
between the two checks the finest, and their difference is added. Where that is not small, a finer
run yet is tried; else the figures are no bound: RunError.settled then says so, and chaos is named.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..model.errors import Diverged, StepTooLarge
from .error import Difference, RunError
from .related_scenes import FinerScenes, exact_scene, finer_scenes
from .run import ENERGY_COLUMNS, Run
from .scene import Scene, objection

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
_PRESENT_AT = 0.01  # errors of the mean speed that a warning names
_AGREE = 0.3  # of a run's error: by how much finer runs may differ
_WILD = 3.0  # body lengths and radians: beyond, runs are apart by chance
_TOO_LITTLE = 1e-3  # for the finest run to be far off, when it differs by no more from the finer
_FAR = 0.1  # body lengths and radians that a warning names
_BELIEVED = 0.01  # body lengths and radians
_CHAOS = 1e4  # times its tolerance: what a smooth motion of a few cycles does not make of it
_RESTS = 1e-4  # body lengths a period: a robot that goes less has no speed worth a share
_UNKNOWN = Difference(math.inf, math.inf, math.inf)


def _common(run: Run, other: Run) -> tuple[Indices, Indices]:
    """Return the indices of the times that both runs recorded, in each."""
    at = np.searchsorted(other.t_s, run.t_s - 1e-9 * run.t_s[-1])
    at = np.minimum(at, other.t_s.size - 1)
    both = np.abs(other.t_s[at] - run.t_s) <= 1e-9 * max(run.t_s[-1], 1e-300)
    return np.nonzero(both)[0], at[both]


def _apart(run: Run, other: Run) -> tuple[Array, Array, Array]:
    """Return the common times, and how far links' centres (m) and angles (rad) are apart then."""
    a, b = _common(run, other)
    position = np.hypot(run.x_m[a] - other.x_m[b], run.y_m[a] - other.y_m[b])
    angle = np.abs(run.theta_rad[a] - other.theta_rad[b])
    return run.t_s[a], position.max(axis=1), angle.max(axis=1)


def difference(run: Run, other: Run) -> Difference:
    """Return how far two runs are apart at the times that both recorded."""
    _, position, angle = _apart(run, other)
    return Difference(
        float(position.max()), float(angle.max()), _share_of_speed(run, other), _energy(run, other)
    )


def _energy(run: Run, other: Run) -> dict[str, float] | None:
    """Return how far each column of two energy ledgers is apart at most, J, or None."""
    if not (run.energy_j.size and other.energy_j.size):
        return None
    a, b = _common(run, other)
    most = abs(run.energy_j[a] - other.energy_j[b]).max(axis=0)
    return dict(zip(ENERGY_COLUMNS, most.tolist(), strict=True))


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
    t, position, angle = _apart(run, other)
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
        off = off.scaled(how.factor)
    word = f"integration: difference to {how.word}"
    return RunError(off, None, word, settled, believed_s, chaotic)


def _integration(run: Run, simulate: Callable[[Scene], Run]) -> RunError:
    found, finest, of = None, None, None
    for how in finer_scenes(run.scene):
        if found is not None and how.finer is not of:
            break  # a pair for want of the one before
        try:
            finer = finest if finest is not None and how.finer is of else simulate(how.finer)
            finest, of = simulate(how.finest), how.finest
        except (Diverged, StepTooLarge):
            continue
        found = _held_against(run, finer, finest, how)
        if found.settled or found.chaotic:
            break
    word = "integration: no finer run comes to its end"
    return found or RunError(_UNKNOWN, None, word, False, 0.0)


def _unsettled(run: Run, error: RunError) -> str:
    """Return what to say of a run whose finer runs do not agree."""
    until = f"believe it up to t = {error.believed_s:.3g} s"
    if error.chaotic:
        return (
            "the motion is chaotic: neighbouring ones part, so that finer runs disagree as much "
            f"among themselves as with this one; {until}, and beyond that only its statistics"
        )
    return (
        "the error estimate is no bound: finer runs disagree as much among themselves as with "
        f"this one; {until}, or take a smaller " + ("tolerance" if run.scene.adaptive else "dt_s")
    )


def _springs_too_soft(scene: Scene, off: Difference) -> list[str]:
    """Return what the springs do to the mean speed, where it is much."""
    springs = f"the springs (k = {scene.joint_stiffness_n_m:g} N/m)"
    if off.mean_speed == math.inf:
        return [
            f"{springs} move a robot that rests in the exact model; take formulation 'explicit'"
        ]
    if not abs(off.mean_speed) > _PRESENT_AT:
        return []
    percent = 100 * off.mean_speed
    return [
        f"{springs} change the mean speed by {percent:+.2g} %; the error falls as 1/k: take k = "
        f"{scene.joint_stiffness_n_m * abs(percent):.1g} N/m for 1 %, or formulation 'explicit'"
    ]


def _steps_too_long(run: Run, off: Difference) -> list[str]:
    """Return what the time steps do to a run, where it is much."""
    take = "take a smaller " + ("tolerance" if run.scene.adaptive else "dt_s")
    if math.isinf(off.position_m):  # no finer run came to its end, which is told already
        return []
    if off.mean_speed == math.inf:
        return [f"the time steps move a robot that rests; {take}"]
    if abs(off.mean_speed) > _PRESENT_AT:
        percent = 100 * abs(off.mean_speed)
        return [f"the time steps change the mean speed by about {percent:.2g} %; {take}"]
    if not off.size(run.scene.robot.body_length_m) <= _FAR:
        return [
            f"the time steps put links off by up to {off.position_m:.2g} m and "
            f"{off.angle_rad:.2g} rad; {take}"
        ]
    return []


def _sticking(scene: Scene) -> str:
    """Return how to have exact sticking in a scene on dry ground."""
    soft = objection("nonsmooth", scene) is not None
    return "method 'nonsmooth'" + (" with formulation 'explicit'" if soft else "")


@dataclass(frozen=True, slots=True)
class RunJudge:
    """Judge runs by further runs of related scenes, which `simulate` makes."""

    simulate: Callable[[Scene], Run]

    def error(self, run: Run) -> RunError:
        """Estimate the error of a run by two more runs, or three for the implicit formulation."""
        scene, found = run.scene, _integration(run, self.simulate)
        if scene.formulation == "explicit":
            return found
        exact = exact_scene(scene, min(scene.tolerance, 1e-6))
        word = f"modelling: difference to the explicit formulation by {exact.method}"
        springs = difference(run, self.simulate(exact))
        return replace(found, modelling=springs, how=f"{found.how}; {word}")

    def warnings(self, run: Run) -> tuple[str, ...]:
        """Return what somebody who uses a run must know."""
        scene, error, found = run.scene, run.error_estimate, []
        if not error.settled:
            found.append(_unsettled(run, error))
        if error.modelling is not None:
            found += _springs_too_soft(scene, error.modelling)
        found += _steps_too_long(run, error.integration)
        if scene.law == "dry" and scene.method != "nonsmooth":
            found.append(
                f"method {scene.method!r} knows nothing of sticking: at rest its wheels chatter, "
                f"and joint torques may be wrong by a third at any step; take {_sticking(scene)}"
            )
        if scene.law == "smoothed":
            found.append(
                f"smoothing_m_s {scene.smoothing_m_s:g} lets stuck wheels creep; take "
                f"smoothing_m_s 0 and {_sticking(replace(scene, smoothing_m_s=0.0, method='rk4'))}"
            )
        return tuple(found)
