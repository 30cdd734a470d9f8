"""What one step of a session is: what to set, in a few words, and which numbers to type then."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from ...model.gait import Gait

# Kinds of quantities and the units that a person may type them in: name -> factor to the first.
UNITS: dict[str, dict[str, float]] = {
    "incline": {"deg": 1.0, "%": 0.0},  # grade: by the arctangent, not by a factor
    "angle": {"deg": 1.0},
    "grade": {"%": 1.0, "deg": 0.0},
    "speed": {"m/s": 1.0, "km/h": 1 / 3.6, "cm/s": 0.01, "mm/s": 0.001, "mph": 0.44704},
    "belt": {"km/h": 1.0, "m/s": 3.6, "mph": 1.609344},  # a treadmill's own steps
    "length": {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254},
    "mass": {"kg": 1.0, "g": 0.001, "lb": 0.45359237},
    "count": {"": 1.0},
    "rate": {"rad/s": 1.0, "Hz": 2 * math.pi},
    "time": {"s": 1.0, "min": 60.0},
}


@dataclass(frozen=True)
class Field:
    """One number to type: the column it goes to, in words, its kind, limits and expected range.

    low, high: beyond them it cannot be. likely: the range that earlier readings let expect, or
    None. usual: what an empty answer means, or None if there is none.
    """

    column: str
    words: str
    kind: str
    low: float
    high: float
    likely: tuple[float, float] | None = None
    usual: float | None = None

    @property
    def unit(self) -> str:
        """Return the unit of a bare number, that of the column."""
        return next(iter(UNITS[self.kind]))


@dataclass(frozen=True)
class Step:
    """One step: `key` names it in events, `say` tells what to set, `fields` what to type.

    kind: zero, straight, bend, station, gait, or done. lambda_deg: the bend it belongs to.
    facing: of the snake, down or up the belt. settle_s: how long to wait before reading. gait: to
    be run.
    """

    key: str
    kind: str
    say: str
    fields: tuple[Field, ...] = ()
    lambda_deg: float = 0.0
    facing: str = "down"
    incline_deg: float = 0.0
    settle_s: float = 0.0
    gait: Gait | None = None
    cells: dict[str, float | str] = field(default_factory=dict)
