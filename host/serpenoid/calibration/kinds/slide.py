"""The kinds on a board: `slide`, the time over a length, and `breakaway`, where it begins."""

from __future__ import annotations

import math
from dataclasses import dataclass

from .bend import bend_in_words
from .declaration import PLANNED, Field, Kind, check_fields
from .station import BEND_WORD, LAMBDA, MAX_INCLINE_DEG

FIELDS = (
    LAMBDA,
    Field(
        "incline_deg",
        "the inclinometer shows on the board",
        "incline",
        0.0,
        MAX_INCLINE_DEG,
        open_low=True,
    ),
    Field(
        "distance_m",
        "length that was timed, from rest",
        "length",
        0.0,
        100.0,
        (0.2, 5.0),
        open_low=True,
    ),
    Field("duration_s", "time taken", "time", 0.0, 1e3, (0.5, 30.0), open_low=True),
    Field(
        "time_sigma_s",
        "standard deviation of the time",
        "time",
        0.0,
        10.0,
        open_low=True,
        source=PLANNED,
        optional=True,
    ),
    BEND_WORD,
)


@dataclass(frozen=True, slots=True)
class Slide:
    """One slide: let go at rest, head down, timed over a length of a board at an incline.

    The board carries the session's surface. incline_rad: as the inclinometer shows it.
    time_sigma_s: None takes that of the set-up's stopwatch. Raises BadInput.
    """

    number: int
    lambda_rad: float
    incline_rad: float
    distance_m: float
    duration_s: float
    time_sigma_s: float | None = None
    bend: str = "zigzag"
    voided: bool = False
    comment: str = ""
    time_utc: str = ""

    def __post_init__(self) -> None:
        check_fields(self, FIELDS)


def _in_words(s: Slide) -> tuple[str, str]:
    bend = bend_in_words(s.lambda_rad)
    values = f"{math.degrees(s.incline_rad):.2f}°, {s.distance_m:.3f} m in {s.duration_s:.2f} s"
    return f"slide{bend}", values


SLIDE = Kind("slide", Slide, FIELDS, _in_words, fitted=True)


BREAKAWAY_FIELDS = (
    LAMBDA,
    Field(
        "incline_deg",
        "the inclinometer shows where it begins to slide",
        "incline",
        0.0,
        MAX_INCLINE_DEG,
        open_low=True,
    ),
    BEND_WORD,
)


@dataclass(frozen=True, slots=True)
class BreakAway:
    """One check of static friction: a board is tilted slowly until the robot on it lets go.

    It tells no friction in motion, so no fit uses it. incline_rad: as the inclinometer shows it.
    Raises BadInput.
    """

    number: int
    lambda_rad: float
    incline_rad: float
    bend: str = "zigzag"
    voided: bool = False
    comment: str = ""
    time_utc: str = ""

    def __post_init__(self) -> None:
        check_fields(self, BREAKAWAY_FIELDS)


def _begins(b: BreakAway) -> tuple[str, str]:
    bend = bend_in_words(b.lambda_rad)
    return f"break-away{bend}", f"{math.degrees(b.incline_rad):.2f}°"


BREAKAWAY = Kind("breakaway", BreakAway, BREAKAWAY_FIELDS, _begins)
