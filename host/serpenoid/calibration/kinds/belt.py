"""The kind `belt`: a mark on the belt timed with a stopwatch, to check the speed that is shown."""

from __future__ import annotations

from dataclasses import dataclass

from ...model.errors import BadInput
from .declaration import Field, Kind, check_fields
from .instruments import MAX_SPEED_M_S, Stopwatch

FIELDS = (
    Field(
        "belt_speed_m_s",
        "belt speed that the treadmill shows",
        "speed",
        0.0,
        MAX_SPEED_M_S,
        open_low=True,
        sheet=("belt_speed_km_h", "km/h"),
    ),
    Field(
        "distance_m",
        "way of the mark in all (turns of the belt times its length)",
        "length",
        0.0,
        1000.0,
        open_low=True,
    ),
    Field("duration_s", "time taken", "time", 0.0, 1e5, (5.0, 600.0), open_low=True),
)


@dataclass(frozen=True, slots=True)
class BeltCheck:
    """A mark on the belt, timed over a way: the true speed over the one that was shown."""

    number: int
    belt_speed_m_s: float
    distance_m: float
    duration_s: float
    voided: bool = False
    comment: str = ""
    time_utc: str = ""
    watch: Stopwatch | None = None  # that it was timed with; None: the session's

    def __post_init__(self) -> None:
        check_fields(self, FIELDS)
        if not self.voided and not 0.5 < self.scale < 2.0:
            raise BadInput(
                f"the belt ran {self.scale:.3g} times as fast as it showed in reading "
                f"{self.number}; it must be 0.5 to 2; check the units, and count all turns"
            )

    @property
    def scale(self) -> float:
        """Return the true speed of the belt over the one shown."""
        return self.distance_m / self.duration_s / self.belt_speed_m_s

    def scale_sigma(self, watch: Stopwatch) -> float:
        """Return the standard deviation of the scale that tape and stopwatch leave."""
        speed_m_s, sigma_m_s = watch.speed(self.distance_m, self.duration_s)
        return self.scale * sigma_m_s / speed_m_s


def _in_words(b: BeltCheck) -> tuple[str, str]:
    values = f"{b.distance_m:.4g} m in {b.duration_s:.4g} s at {b.belt_speed_m_s:.4g} m/s shown"
    return "belt check", f"{values}: true speed {b.scale:.4g} times the one shown"


BELT = Kind("belt", BeltCheck, FIELDS, _in_words, fitted=True)
