"""What an estimate of a run's error consists of, and the warnings that follow from it."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, replace
from typing import Any

from ..base.rows import Result, Row, detail
from .scene import MIN_TOLERANCE, Scene, objection

WARNED_SPEED = 0.01  # relative error of the mean speed that a warning names
WARNED_SIZE = 0.1  # body lengths and radians that a warning names


@dataclass(frozen=True, slots=True)
class Difference:
    """Hold the largest differences between two runs over their common recorded times.

    position_m: of any link's centre. angle_rad: of any link. mean_speed: of the centre of mass from
    start to end, relative to the other run: nan where both rest, inf where only the other does. A
    run rests that goes less than 1e-4 of its body's length a period. energy_j: of each column
    of the energy ledger (Run.energy_j), by its name; None where one of the two did not record it.
    """

    position_m: float
    angle_rad: float
    mean_speed: float
    energy_j: dict[str, float] | None = None

    def in_words(self) -> str:
        """Return places, angles and mean speed in one line."""
        speed = f", mean speed {self.mean_speed:+.2g}" if math.isfinite(self.mean_speed) else ""
        return f"{self.position_m:.2g} m, {self.angle_rad:.2g} rad{speed}"

    def size(self, body_m: float) -> float:
        """Return the larger of position in body lengths and angle in radians."""
        return max(self.position_m / body_m, self.angle_rad)


@dataclass(frozen=True, slots=True)
class RunError(Result):
    """Hold the estimated errors of a run.

    integration: of the method, four times the difference from a finer run. modelling: of the
    springs, from a run of the exact model; None for the explicit formulation, which has none. how:
    in words. settled: whether a yet finer run is nearer to the finer one than that is to the run;
    where it is not, the figures are no bound. believed_s: the time up to which the finer run agrees
    with this one to a hundredth of a body length and of a radian.
    """

    integration: Difference
    modelling: Difference | None
    how: str
    settled: bool = True
    believed_s: float = 0.0

    def rows(self) -> list[Row]:
        """Return the errors of time steps and springs."""
        parts = {"integration": self.integration, "modelling (springs)": self.modelling}
        return [
            detail(f"error by {name}", "", words=part.in_words())
            for name, part in parts.items()
            if part is not None
        ]

    def to_dict(self) -> dict[str, Any]:
        """Return it for a JSON answer."""
        return asdict(self)

    def worst(self, body_m: float) -> float:
        """Return the largest error, positions in body lengths and angles in radians."""
        return sum(part.size(body_m) for part in (self.integration, self.modelling) if part)


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


def warnings_of(scene: Scene, error: RunError) -> tuple[str, ...]:
    """Return what somebody who uses a run of a scene with such an error must know."""
    finer = "take a smaller " + ("tolerance" if scene.adaptive else "dt_s")
    difference, body_m = error.integration, scene.robot.body_length_m
    warnings: list[str] = []
    if not error.settled:
        warnings.append(
            "the error estimate is no bound: finer runs disagree as much among themselves as with "
            f"this one; believe it up to t = {error.believed_s:.3g} s, or {finer}"
        )
    if error.modelling is not None:
        warnings += _springs_too_soft(scene, error.modelling.mean_speed)
    if difference.mean_speed == math.inf and math.isfinite(difference.position_m):
        warnings.append(f"the time steps move a robot that rests; {finer}")
    elif WARNED_SPEED < abs(difference.mean_speed) < math.inf:
        percent = 100 * abs(difference.mean_speed)
        warnings.append(f"the time steps may change the mean speed by {percent:.2g} %; {finer}")
    elif WARNED_SIZE < difference.size(body_m) < math.inf:
        warnings.append(
            f"the time steps may put links off by {difference.position_m:.2g} m and "
            f"{difference.angle_rad:.2g} rad; {finer}"
        )
    if chatters(scene):
        soft = objection("nonsmooth", scene) is not None
        warnings.append(
            f"method {scene.method!r} knows nothing of sticking: at rest its wheels chatter, and "
            "joint torques may be wrong by a third at any step; take method 'nonsmooth'"
            + (" with formulation 'explicit'" if soft else "")
        )
    return tuple(warnings)


def chatters(scene: Scene) -> bool:
    """Return whether dry friction meets a method that does not know sticking."""
    return scene.law == "dry" and scene.method != "nonsmooth"


def _springs_too_soft(scene: Scene, speed_error: float) -> list[str]:
    """Return what the springs do to the mean speed, where it is much."""
    springs = f"the springs (k = {scene.joint_stiffness_n_m:g} N/m)"
    if speed_error == math.inf:
        return [
            f"{springs} move a robot that rests in the exact model; take formulation 'explicit'"
        ]
    if not abs(speed_error) > WARNED_SPEED:
        return []
    percent = 100 * speed_error
    return [
        f"{springs} change the mean speed by {percent:+.2g} %; the error falls as 1/k: take "
        f"k = {scene.joint_stiffness_n_m * abs(percent):.1g} N/m for 1 %, or formulation "
        "'explicit'"
    ]
