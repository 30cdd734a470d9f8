"""The kinds on a board: `slide`, the time over a length, and `breakaway`, where it begins."""

from __future__ import annotations

import math
from dataclasses import dataclass

from .declaration import PLANNED, Field, Taken
from .station import BEND_WORD, LAMBDA, MAX_INCLINE_DEG, bend_in_words


@dataclass(frozen=True, slots=True)
class Slide(Taken):
    """One slide: let go at rest, head down, timed over a length of a board at an incline.

    The board carries the session's surface. incline_rad: as the inclinometer shows it.
    time_sigma_s: None takes that of the set-up's stopwatch. Raises BadInput.
    """

    kind = "slide"
    fitted = True
    fields = (
        LAMBDA,
        Field(
            "incline_deg",
            "the inclinometer shows on the board",
            0.0,
            MAX_INCLINE_DEG,
            open_low=True,
        ),
        Field(
            "distance_m",
            "length that was timed, from rest",
            0.0,
            100.0,
            (0.2, 5.0),
            open_low=True,
        ),
        Field("duration_s", "time taken", 0.0, 1e3, (0.5, 30.0), open_low=True),
        Field(
            "time_sigma_s",
            "standard deviation of the time",
            0.0,
            10.0,
            open_low=True,
            source=PLANNED,
            optional=True,
        ),
        BEND_WORD,
    )

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

    def in_words(self) -> tuple[str, str]:
        """Return what it is, and its values."""
        return f"slide{bend_in_words(self.lambda_rad)}", (
            f"{math.degrees(self.incline_rad):.2f}°, {self.distance_m:.3f} m in "
            f"{self.duration_s:.2f} s"
        )


@dataclass(frozen=True, slots=True)
class BreakAway(Taken):
    """One check of static friction: a board is tilted slowly until the robot on it lets go.

    It tells no friction in motion, so no fit uses it. incline_rad: as the inclinometer shows it.
    Raises BadInput.
    """

    kind = "breakaway"
    fields = (
        LAMBDA,
        Field(
            "incline_deg",
            "the inclinometer shows where it begins to slide",
            0.0,
            MAX_INCLINE_DEG,
            open_low=True,
        ),
        BEND_WORD,
    )

    number: int
    lambda_rad: float
    incline_rad: float
    bend: str = "zigzag"
    voided: bool = False
    comment: str = ""
    time_utc: str = ""

    def in_words(self) -> tuple[str, str]:
        """Return what it is, and its values."""
        bend = bend_in_words(self.lambda_rad)
        return f"break-away{bend}", f"{math.degrees(self.incline_rad):.2f}°"
