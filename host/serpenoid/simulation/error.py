"""What is known of a run's error, by its time steps and by its springs, and warnings of it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any

from ..base.rows import Result, Row, detail
from .scene import Scene, objection

_PRESENT_AT = 0.01  # errors of the mean speed that a warning names
_FAR = 0.1  # body lengths and radians that a warning names


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

    def grown(self, factor: float = 1.0, by: Difference | None = None) -> Difference:
        """Return all of them times a factor, with another's sizes added to each, signs kept."""
        more = by or Difference(0.0, 0.0, 0.0)
        speed, doubt = factor * self.mean_speed, more.energy_j or {}
        return Difference(
            factor * self.position_m + more.position_m,
            factor * self.angle_rad + more.angle_rad,
            speed + math.copysign(more.mean_speed, speed),
            self.energy_j
            and {name: factor * j + doubt.get(name, 0.0) for name, j in self.energy_j.items()},
        )

    def in_words(self) -> str:
        """Return places, angles and mean speed in one line."""
        speed = f"{self.mean_speed:+.2g}"
        if math.isinf(self.mean_speed):
            speed = "of what should rest"
        elif math.isnan(self.mean_speed):
            speed = "of nothing: at rest"
        return f"{self.position_m:.2g} m, {self.angle_rad:.2g} rad, mean speed {speed}"

    def size(self, body_m: float) -> float:
        """Return the larger of position in body lengths and angle in radians."""
        return max(self.position_m / body_m, self.angle_rad)


@dataclass(frozen=True, slots=True)
class RunError(Result):
    """Split what is known of a run's error.

    integration: of the method, from two runs that are finer than it (judge.py). modelling: of the
    springs, from a run of the exact model; None for the explicit formulation, which has none. How:
    in words. settled: whether the finer runs agree among themselves; where they do not, the figures
    are the size of the disagreement and no bound: the run cannot be told to be better than that.
    believed_s: the time up to which the finer runs agree with this one to a hundredth of a body
    length and of a radian. chaotic: whether they part because neighbouring motions do.
    """

    integration: Difference
    modelling: Difference | None
    how: str
    settled: bool = True
    believed_s: float = 0.0
    chaotic: bool = False

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


def warnings_of(scene: Scene, error: RunError) -> tuple[str, ...]:
    """Return what somebody who uses a run of a scene with such an error must know."""
    finer = "take a smaller " + ("tolerance" if scene.adaptive else "dt_s")
    return (
        *_unsettled(error, finer),
        *_springs_too_soft(scene, error.modelling),
        *_steps_too_long(error.integration, scene.robot.body_length_m, finer),
        *_no_sticking(scene),
    )


def _unsettled(error: RunError, finer: str) -> Iterator[str]:
    """Say that the finer runs of a run do not agree."""
    if error.settled:
        return
    until = f"believe it up to t = {error.believed_s:.3g} s"
    if error.chaotic:
        yield (
            "the motion is chaotic: neighbouring ones part, so that finer runs disagree as much "
            f"among themselves as with this one; {until}, and beyond that only its statistics"
        )
    else:
        yield (
            "the error estimate is no bound: finer runs disagree as much among themselves as with "
            f"this one; {until}, or {finer}"
        )


def _springs_too_soft(scene: Scene, off: Difference | None) -> Iterator[str]:
    """Say what the springs do to the mean speed, where it is much."""
    springs = f"the springs (k = {scene.joint_stiffness_n_m:g} N/m)"
    if off is not None and off.mean_speed == math.inf:
        yield f"{springs} move a robot that rests in the exact model; take formulation 'explicit'"
    elif off is not None and abs(off.mean_speed) > _PRESENT_AT:
        percent = 100 * off.mean_speed
        yield (
            f"{springs} change the mean speed by {percent:+.2g} %; the error falls as 1/k: take "
            f"k = {scene.joint_stiffness_n_m * abs(percent):.1g} N/m for 1 %, or formulation "
            "'explicit'"
        )


def _steps_too_long(off: Difference, body_m: float, finer: str) -> Iterator[str]:
    """Say what the time steps do to a run, where it is much."""
    if math.isinf(off.position_m):  # no finer run came to its end, which is said already
        return
    if off.mean_speed == math.inf:
        yield f"the time steps move a robot that rests; {finer}"
    elif abs(off.mean_speed) > _PRESENT_AT:
        percent = 100 * abs(off.mean_speed)
        yield f"the time steps change the mean speed by about {percent:.2g} %; {finer}"
    elif not off.size(body_m) <= _FAR:
        yield (
            f"the time steps put links off by up to {off.position_m:.2g} m and "
            f"{off.angle_rad:.2g} rad; {finer}"
        )


def _no_sticking(scene: Scene) -> Iterator[str]:
    """Say what a scene on dry ground loses whose wheels cannot stick."""
    if scene.law == "dry" and scene.method != "nonsmooth":
        yield (
            f"method {scene.method!r} knows nothing of sticking: at rest its wheels chatter, and "
            f"joint torques may be wrong by a third at any step; take {_sticking(scene)}"
        )


def _sticking(scene: Scene) -> str:
    """Return how to have exact sticking in a scene on dry ground."""
    soft = objection("nonsmooth", scene) is not None
    return "method 'nonsmooth'" + (" with formulation 'explicit'" if soft else "")
