"""The kind `zero`: the inclinometer's zero by reversal."""

from __future__ import annotations

import math
from dataclasses import dataclass

from .declaration import Field, Kind, check_fields
from .instruments import Uncertainty
from .station import MAX_INCLINE_DEG

LIKELY_DEG = (-5.0, 5.0)
FIELDS = (
    Field(
        "incline_deg",
        "it shows",
        "incline",
        -MAX_INCLINE_DEG,
        MAX_INCLINE_DEG,
        LIKELY_DEG,
        attribute="shown_rad",
    ),
    Field(
        "reversed_deg",
        "turned, it shows",
        "incline",
        -MAX_INCLINE_DEG,
        MAX_INCLINE_DEG,
        LIKELY_DEG,
        why="the zero would be beyond 0.5 deg: was a sign forgotten?",
    ),
)


@dataclass(frozen=True, slots=True)
class ZeroReading:
    """The inclinometer read twice on one spot, the second time turned end for end.

    What stays of the sum is twice its zero. before: taken before the first station.
    """

    number: int
    shown_rad: float
    reversed_rad: float
    before: bool = True
    voided: bool = False
    comment: str = ""
    time_utc: str = ""
    uncertainty: Uncertainty | None = None

    def __post_init__(self) -> None:
        check_fields(self, FIELDS)

    @property
    def zero_rad(self) -> float:
        """Return what the inclinometer shows where it is level."""
        return (self.shown_rad + self.reversed_rad) / 2


def _in_words(z: ZeroReading) -> tuple[str, str]:
    shown, turned = math.degrees(z.shown_rad), math.degrees(z.reversed_rad)
    values = f"{shown:+.2f}°, turned {turned:+.2f}°: zero {math.degrees(z.zero_rad):+.3f}°"
    return f"inclinometer, {'before' if z.before else 'after'}", values


ZERO = Kind("zero", ZeroReading, FIELDS, _in_words, "zeros", fitted=True)
