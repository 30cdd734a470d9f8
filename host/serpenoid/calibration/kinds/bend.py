"""The kind `bend`: a protractor held between links of a bent robot."""

from __future__ import annotations

import math
from dataclasses import dataclass

from .declaration import Field, Kind, check_fields
from .station import BEND_WORD, LAMBDA

FIELDS = (
    LAMBDA,
    Field("between_links_deg", "the protractor shows", "angle", 0.0, 180.0),
    BEND_WORD,
)


def bend_in_words(lambda_rad: float) -> str:
    """Return how the robot lies: ", bend 20°" or ", straight"."""
    return f", bend {math.degrees(lambda_rad):.4g}°" if lambda_rad else ", straight"


@dataclass(frozen=True, slots=True)
class BendCheck:
    """The protractor held between the last two links at an end of a bent robot.

    There a joint stands at 2 lambda in either bend, zigzag or balanced.
    """

    number: int
    lambda_rad: float
    between_links_rad: float
    voided: bool = False
    comment: str = ""
    time_utc: str = ""
    bend: str = "zigzag"

    def __post_init__(self) -> None:
        check_fields(self, FIELDS)

    @property
    def found_rad(self) -> float:
        """Return the lambda that the protractor shows: links stand at pi - 2 lambda."""
        return (math.pi - self.between_links_rad) / 2


def _in_words(b: BendCheck) -> tuple[str, str]:
    shown, found = math.degrees(b.between_links_rad), math.degrees(b.found_rad)
    values = f"{shown:.4g}° between links: λ = {found:.4g}°"
    return f"protractor, bend {math.degrees(b.lambda_rad):.4g}°", values


BEND = Kind("bend", BendCheck, FIELDS, _in_words, "bends")
