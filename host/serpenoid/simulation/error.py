"""How far a run may be off: a run at another step, and the exact model beside the springs."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..model.errors import Diverged, StepTooLarge
from .methods import METHODS
from .scene import Scene
from .stability import largest_step_s, stability_test

if TYPE_CHECKING:
    from .simulate import Run

Array = NDArray[np.float64]
Simulate = Callable[[Scene], "Run"]
_PRESENT_AT = 0.01  # errors of the mean speed that a warning names


@dataclass(frozen=True, slots=True)
class Difference:
    """Hold the largest differences between two runs over their common recorded times.

    position_m: of any link's centre. angle_rad: of any link. mean_speed: of the centre of mass from
    start to end, relative to the other run (nan if that gets nowhere).
    """

    position_m: float
    angle_rad: float
    mean_speed: float

    def scaled(self, factor: float) -> Difference:
        """Return all three times a factor."""
        return Difference(
            factor * self.position_m, factor * self.angle_rad, factor * self.mean_speed
        )


@dataclass(frozen=True, slots=True)
class RunError:
    """Split what is known of a run's error.

    integration: of the method, from a second run (Richardson). modelling: of the springs, from a
    run of the exact model; None for the explicit formulation, which has none. How: in words.
    """

    integration: Difference
    modelling: Difference | None
    how: str

    def to_dict(self) -> dict[str, Any]:
        """Return it for a JSON answer."""
        return asdict(self)

    def worst(self, body_m: float) -> float:
        """Return the largest error, positions in body lengths and angles in radians."""
        parts = [self.integration] + ([self.modelling] if self.modelling else [])
        return sum(max(p.position_m / body_m, p.angle_rad) for p in parts)


def _travel(run: Run) -> float:
    x, y = run.x_m.mean(axis=1), run.y_m.mean(axis=1)
    return math.hypot(x[-1] - x[0], y[-1] - y[0])


def difference(run: Run, other: Run) -> Difference:
    """Return how far two runs are apart at the times that both recorded."""
    at = np.searchsorted(other.t_s, run.t_s - 1e-9 * run.t_s[-1])
    at = np.minimum(at, other.t_s.size - 1)
    both = np.abs(other.t_s[at] - run.t_s) <= 1e-9 * max(run.t_s[-1], 1e-300)
    a, b = np.nonzero(both)[0], at[both]
    position = np.hypot(run.x_m[a] - other.x_m[b], run.y_m[a] - other.y_m[b])
    angle = np.abs(run.theta_rad[a] - other.theta_rad[b])
    goes = _travel(other)
    speed = (_travel(run) - goes) / goes if goes > 0 else math.nan
    return Difference(float(position.max()), float(angle.max()), speed)


def plain(scene: Scene) -> bool:
    """Tell whether all joints follow the gait, on the level."""
    return follows_gait(scene) and not scene.incline_rad


def follows_gait(scene: Scene) -> bool:
    """Tell whether all joints follow the gait."""
    return scene.drive == "angle" and not (scene.limp or scene.locked)


def exact_scene(scene: Scene, tolerance: float) -> Scene | None:
    """Return a scene in the explicit formulation, by the best method for it; None if none is good.

    (Dry friction needs exact sticking; the explicit formulation has it if all joints follow the
    gait.)
    """
    if scene.law == "dry":
        method = "nonsmooth"
        if not follows_gait(scene) or scene.gait.alpha_rad == scene.gait.offset_rad == 0:
            return None
    else:
        method = "collocation" if plain(scene) and scene.law == "viscous" else "dop853"
    return replace(scene, formulation="explicit", tolerance=tolerance, record=(), method=method)


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


def estimate(run: Run, simulate: Simulate) -> RunError:
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


def stiffer_scene(scene: Scene, factor: float) -> Scene:
    """Return an implicit scene with springs and dampers stiffer by a factor, at a stable step."""
    scene = replace(
        scene, record=(), joint_stiffness_n_m=factor * scene.joint_stiffness_n_m,
        joint_damping_n_s_m=factor * scene.joint_damping_n_s_m,
    )  # fmt: skip
    limit = largest_stable_step_s(scene) / 2
    if scene.adaptive or scene.dt_s <= limit:
        return scene
    split = math.ceil(scene.dt_s / limit)
    return replace(scene, dt_s=scene.dt_s / split, record_every=split * scene.every)


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
    if not abs(error.integration.mean_speed) <= _PRESENT_AT and _travel(run) > 0:
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


def largest_stable_step_s(scene: Scene) -> float:
    """Return the largest stable fixed step of a scene, s, at most its gait's period / 20."""
    most = scene.gait.period_s / 20
    stable = stability_test(scene)
    if stable is None or stable(most):
        return most
    return largest_step_s(stable, most)
