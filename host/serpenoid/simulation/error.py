"""What is known of a run's error: by its time steps, and by its springs."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any


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

    def size(self, body_m: float) -> float:
        """Return the larger of position in body lengths and angle in radians."""
        return max(self.position_m / body_m, self.angle_rad)


@dataclass(frozen=True, slots=True)
class RunError:
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

    def to_dict(self) -> dict[str, Any]:
        """Return it for a JSON answer."""
        return asdict(self)

    def worst(self, body_m: float) -> float:
        """Return the largest error, positions in body lengths and angles in radians."""
        parts = [self.integration] + ([self.modelling] if self.modelling else [])
        return sum(part.size(body_m) for part in parts)
