"""What is known of a run's error: by its time steps, and by its springs."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

from ..model.rows import Result, Row, detail


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

    def scaled(self, factor: float) -> Difference:
        """Return all of them times a factor."""
        return Difference(
            factor * self.position_m,
            factor * self.angle_rad,
            factor * self.mean_speed,
            self.energy_j and {name: factor * size for name, size in self.energy_j.items()},
        )

    def beside(self, other: Difference) -> Difference:
        """Return the same with another difference's sizes added to each size, signs kept."""
        speed, more = self.mean_speed, abs(other.mean_speed)
        doubt = other.energy_j or {}
        return Difference(
            self.position_m + other.position_m,
            self.angle_rad + other.angle_rad,
            speed + (more if speed >= 0 else -more),
            self.energy_j and {k: size + doubt.get(k, 0.0) for k, size in self.energy_j.items()},
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
