"""What is known of a run's error: by its time steps, and by its springs."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any


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
