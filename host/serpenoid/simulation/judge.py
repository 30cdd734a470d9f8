"""How far a run may be off: a run at another step, and the exact model beside the springs."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ..model.errors import Diverged, StepTooLarge
from .error import Difference, RunError
from .methods import METHODS
from .related_scenes import exact_scene, stiffer_scene
from .run import Run
from .scene import Scene
from .stability import stability_test

_PRESENT_AT = 0.01  # errors of the mean speed that a warning names


@dataclass(frozen=True, slots=True)
class RunJudge:
    """Judge runs by further runs of related scenes, which `simulate` makes."""

    simulate: Callable[[Scene], Run]

    def error(self, run: Run) -> RunError:
        """Estimate the error of a run by one more run, or two for the implicit formulation."""
        return estimate(run, self.simulate)

    def warnings(self, run: Run) -> tuple[str, ...]:
        """Return what somebody who uses a run must know."""
        return warnings_of(run, run.error_estimate)


def difference(run: Run, other: Run) -> Difference:
    """Return how far two runs are apart at the times that both recorded."""
    at = np.searchsorted(other.t_s, run.t_s - 1e-9 * run.t_s[-1])
    at = np.minimum(at, other.t_s.size - 1)
    both = np.abs(other.t_s[at] - run.t_s) <= 1e-9 * max(run.t_s[-1], 1e-300)
    a, b = np.nonzero(both)[0], at[both]
    position = np.hypot(run.x_m[a] - other.x_m[b], run.y_m[a] - other.y_m[b])
    angle = np.abs(run.theta_rad[a] - other.theta_rad[b])
    goes = other.travel_m
    speed = (run.travel_m - goes) / goes if goes > 0 else math.nan
    return Difference(float(position.max()), float(angle.max()), speed)


def _order(scene: Scene) -> int:
    """Return the order by which to trust two steps: kinks of friction or servos leave the first."""
    return 1 if scene.law == "dry" or scene.servo else METHODS[scene.method].order


def _other_step(scene: Scene) -> tuple[Scene, float, str]:
    """Return the scene at another step, by what to multiply the difference, and a word on it."""
    if scene.adaptive:
        loose = min(10 * scene.tolerance, 0.1)
        return replace(scene, tolerance=loose, record=()), 0.25, f"tolerance {loose:g}"
    power, every = 2 ** _order(scene), scene.every
    stable = stability_test(scene)
    if every % 2 == 0 or every == 1:
        double = replace(scene, dt_s=2 * scene.dt_s, record_every=max(every // 2, 1), record=())
        if double.steps >= 4 and (stable is None or stable(double.dt_s)):
            return double, 1 / (power - 1), f"dt_s {double.dt_s:g}"
    half = replace(scene, dt_s=scene.dt_s / 2, record_every=2 * every, record=())
    return half, power / (power - 1), f"dt_s {half.dt_s:g}"


def estimate(run: Run, simulate: Callable[[Scene], Run]) -> RunError:
    """Estimate the error of a run by one more run, or two for the implicit formulation."""
    scene = run.scene
    other, factor, word = _other_step(scene)
    try:
        integration = difference(run, simulate(other)).scaled(factor)
    except (Diverged, StepTooLarge):
        integration = Difference(math.inf, math.inf, math.inf)
    how = f"integration: {factor:.3g} of the difference to a run at {word}"
    if scene.formulation == "explicit":
        return RunError(integration, None, how)
    exact = exact_scene(scene, min(scene.tolerance, 1e-6))
    if exact is not None:
        how += f"; modelling: difference to the explicit formulation by {exact.method}"
        return RunError(integration, difference(run, simulate(exact)), how)
    stiffer = stiffer_scene(scene, 4.0)
    how += f"; modelling: 4/3 of the difference to k = {stiffer.joint_stiffness_n_m:g} N/m"
    return RunError(integration, difference(run, simulate(stiffer)).scaled(4 / 3), how)


def warnings_of(run: Run, error: RunError) -> tuple[str, ...]:
    """Return what somebody who uses this run must know."""
    scene, found = run.scene, []
    if error.modelling is not None and abs(error.modelling.mean_speed) > _PRESENT_AT:
        percent = 100 * error.modelling.mean_speed
        exact = exact_scene(scene, scene.tolerance) is not None
        found.append(
            f"the springs (k = {scene.joint_stiffness_n_m:g} N/m) change the mean speed by "
            f"{percent:+.2g} %; the error falls as 1/k: take k = "
            f"{scene.joint_stiffness_n_m * abs(percent):.1g} N/m for 1 %"
            + (", or formulation 'explicit'" if exact else "")
        )
    if not abs(error.integration.mean_speed) <= _PRESENT_AT and run.travel_m > 0:
        percent = 100 * abs(error.integration.mean_speed)
        found.append(
            f"the time steps change the mean speed by about {percent:.2g} %; take a smaller "
            + ("tolerance" if scene.adaptive else "dt_s")
        )
    if scene.law == "dry" and scene.method != "nonsmooth":
        found.append(
            f"method {scene.method!r} knows nothing of sticking: at rest its wheels chatter, and "
            "joint torques may be wrong by a third at any step; take method 'nonsmooth'"
        )
    if scene.law == "smoothed":
        found.append(
            f"smoothing_m_s {scene.smoothing_m_s:g} lets stuck wheels creep; take method "
            "'nonsmooth' with smoothing_m_s 0"
        )
    return tuple(found)
