"""Checks of what is measured with: the kinds `zero`, `bend` and `belt`."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ..base.errors import BadInput
from .declaration import PLANNED, Taken, number_field, word_field
from .instruments import MAX_INCLINE_DEG, MAX_LAMBDA_DEG, MAX_SPEED_M_S, Instruments
from .station import BENDS

LIKELY_DEG = (-5.0, 5.0)


@dataclass(frozen=True)
class ZeroReading(Taken):
    """The inclinometer read twice on one spot, the second time turned end for end.

    What stays of the sum is twice its zero. before: taken before the first station.
    """

    kind = "zero"
    part = "zeros"
    fitted = True

    number: int
    incline_rad: float = number_field(
        -MAX_INCLINE_DEG, MAX_INCLINE_DEG, words="it shows", likely=LIKELY_DEG
    )
    reversed_rad: float = number_field(
        -MAX_INCLINE_DEG,
        MAX_INCLINE_DEG,
        words="turned, it shows",
        likely=LIKELY_DEG,
        why="the zero would be beyond 0.5 deg: was a sign forgotten?",
    )
    before: bool = True
    voided: bool = False
    comment: str = ""
    time_utc: str = ""

    @property
    def zero_rad(self) -> float:
        """Return what the inclinometer shows where it is level."""
        return (self.incline_rad + self.reversed_rad) / 2

    def in_words(self) -> tuple[str, str]:
        """Return what it is, and its values."""
        shown, turned = math.degrees(self.incline_rad), math.degrees(self.reversed_rad)
        values = f"{shown:+.2f}°, turned {turned:+.2f}°: zero {math.degrees(self.zero_rad):+.3f}°"
        return f"inclinometer, {'before' if self.before else 'after'}", values


@dataclass(frozen=True)
class BendCheck(Taken):
    """The protractor held between the last two links at an end of a bent robot.

    There a joint stands at 2 lambda in either bend, zigzag or balanced.
    """

    kind = "bend"
    part = "bends"

    number: int
    lambda_rad: float = number_field(0.0, MAX_LAMBDA_DEG, source=PLANNED)
    between_links_rad: float = number_field(0.0, 180.0, words="the protractor shows")
    voided: bool = False
    comment: str = ""
    time_utc: str = ""
    bend: str = word_field(*BENDS, of_plan=True)

    @property
    def found_rad(self) -> float:
        """Return the lambda that the protractor shows: links stand at pi - 2 lambda."""
        return (math.pi - self.between_links_rad) / 2

    def in_words(self) -> tuple[str, str]:
        """Return what it is, and its values."""
        between_deg, lambda_deg = map(math.degrees, (self.between_links_rad, self.found_rad))
        values = f"{between_deg:.4g}° between links: λ = {lambda_deg:.4g}°"
        return f"protractor, bend {math.degrees(self.lambda_rad):.4g}°", values


@dataclass(frozen=True)
class BeltCheck(Taken):
    """A mark on the belt, timed over a way: the true speed over the one that was shown."""

    kind = "belt"
    fitted = True

    number: int
    belt_speed_m_s: float = number_field(
        0.0,
        MAX_SPEED_M_S,
        words="belt speed that the treadmill shows",
        open_low=True,
    )
    distance_m: float = number_field(
        0.0,
        1000.0,
        words="way of the mark in all (turns of the belt times its length)",
        open_low=True,
    )
    duration_s: float = number_field(
        0.0, 1e5, words="time taken", likely=(5.0, 600.0), open_low=True
    )
    voided: bool = False
    comment: str = ""
    time_utc: str = ""

    def __post_init__(self) -> None:
        Taken.__post_init__(self)
        if not self.voided and not 0.5 < self.scale < 2.0:
            raise BadInput(
                f"the belt ran {self.scale:.3g} times as fast as it showed in reading "
                f"{self.number}; it must be 0.5 to 2; check the units, and count all turns"
            )

    @property
    def scale(self) -> float:
        """Return the true speed of the belt over the one shown."""
        return self.distance_m / self.duration_s / self.belt_speed_m_s

    def scale_sigma(self, watch: Instruments) -> float:
        """Return the standard deviation of the scale that tape and stopwatch leave."""
        speed_m_s, sigma_m_s = watch.speed(self.distance_m, self.duration_s)
        return self.scale * sigma_m_s / speed_m_s

    def in_words(self) -> tuple[str, str]:
        """Return what it is, and its values."""
        return "belt check", (
            f"{self.distance_m:.4g} m in {self.duration_s:.4g} s at {self.belt_speed_m_s:.4g} m/s "
            f"shown: true speed {self.scale:.4g} times the one shown"
        )
