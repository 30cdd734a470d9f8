"""The crawling robot: the kinds `gait`, timed between marks, and `video`, measured in a film."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from ..base.errors import BadInput
from ..model.gait import Gait
from .declaration import DERIVED, PLANNED, Taken, number_field, word_field
from .settings import MAX_SPEED_M_S, Instruments
from .track import Track

RUN_WAYS = ("level", "there", "back")  # along the line of the pushes, where a floor slopes
TRACK = ("t_s", "x_m", "y_m", "heading_rad", "joint*_rad")


@dataclass(frozen=True)
class GaitRun(Taken):
    """One measured speed of the crawling robot, on level ground of the session's surface.

    number: from 1, unique among all readings of the session. omega_rad_s: the true rate, from the
    board's clock. speed_m_s: of the robot over ground, 0 where it got nowhere. distance_m,
    duration_s: what it follows from, None where it was given itself. way: along the line of the
    pushes, on a floor that may slope, or on level ground. Raises BadInput.
    """

    kind = "gait"

    number: int
    alpha_rad: float = number_field(0.0, 180.0, source=PLANNED)
    beta_rad: float = number_field(-360.0, 360.0, source=PLANNED)
    omega_rad_s: float = number_field(0.0, 1000.0, open_low=True, source=PLANNED)
    speed_m_s: float = number_field(0.0, MAX_SPEED_M_S, source=DERIVED)
    speed_sigma_m_s: float = number_field(0.0, MAX_SPEED_M_S, open_low=True, source=DERIVED)
    voided: bool = False
    comment: str = ""
    time_utc: str = ""
    distance_m: float | None = number_field(
        0.0, 1000.0, words="distance between the marks", default=None, likely=(0.05, 10.0)
    )
    duration_s: float | None = number_field(
        0.0, 1e5, words="time taken", default=None, likely=(1.0, 600.0), open_low=True
    )
    way: str = word_field(*RUN_WAYS)

    @property
    def gait(self) -> Gait:
        """Return the gait that was run."""
        return Gait(self.alpha_rad, self.beta_rad, self.omega_rad_s)

    @classmethod
    def derived(cls, cells: dict[str, Any], watch: Instruments) -> dict[str, Any]:
        """Put in the speed that distance and time give, unless it is given itself."""
        there = [name for name in ("distance_m", "duration_s") if name in cells]
        if not there or "speed_m_s" in cells:
            return cells
        if len(there) < 2:
            missing = "duration_s" if there == ["distance_m"] else "distance_m"
            raise BadInput(f"a gait run needs both distance_m and duration_s; {missing} is missing")
        speed, sigma = watch.speed(*(float(cells[name]) for name in there))
        return {"speed_m_s": speed, "speed_sigma_m_s": sigma} | cells

    def in_words(self) -> tuple[str, str]:
        """Return what it is, and its values."""
        alpha, beta = math.degrees(self.alpha_rad), math.degrees(self.beta_rad)
        what = f"gait {alpha:.3g}°/{beta:.3g}°, {self.omega_rad_s / (2 * math.pi):.3g} Hz"
        return what, f"{self.speed_m_s:.4f} ± {self.speed_sigma_m_s:.4f} m/s"


@dataclass(frozen=True)
class FilmReading(Taken):
    """What a film showed of a gait run on level ground of the session's surface.

    alpha_rad, beta_rad: commanded, or where nobody told, the mean of what was seen. omega_rad_s,
    offset_rad, speed_m_s: seen. gains, shifts_deg: of every joint beside the commanded sine, tail
    first, between commas: amplitude as a factor, phase in degrees. film_sha256: of the film's file.
    way: as of a gait run. Raises BadInput.
    """

    kind = "video"
    columns = TRACK

    number: int
    alpha_rad: float = number_field(0.0, 180.0, source=PLANNED)
    beta_rad: float = number_field(-360.0, 360.0, source=PLANNED)
    omega_rad_s: float = number_field(0.0, 1000.0, open_low=True, source=DERIVED)
    speed_m_s: float = number_field(0.0, MAX_SPEED_M_S, source=DERIVED)
    speed_sigma_m_s: float = number_field(0.0, MAX_SPEED_M_S, open_low=True, source=DERIVED)
    offset_rad: float = number_field(-180.0, 180.0, source=DERIVED)
    gain_sigma: float = number_field(0.0, 2.0, source=DERIVED)
    gains: str = word_field()
    shifts_deg: str = word_field()
    film_sha256: str = word_field()
    way: str = word_field(*RUN_WAYS)
    track: Track | None = None
    voided: bool = False
    comment: str = ""
    time_utc: str = ""

    def __post_init__(self) -> None:
        if not self.gains or len(_numbers("gains", self.gains)) != len(
            _numbers("shifts_deg", self.shifts_deg)
        ):
            raise BadInput(
                f"gains is {self.gains!r} and shifts_deg {self.shifts_deg!r}; they must be one "
                "number a joint each, between commas"
            )

    @property
    def commanded(self) -> Gait:
        """Return the gait that was commanded, at the rate that was seen."""
        return Gait(self.alpha_rad, self.beta_rad, self.omega_rad_s)

    @property
    def gait(self) -> Gait:
        """Return the gait that the joints made."""
        gains = _numbers("gains", self.gains)
        shifts = [math.radians(x) for x in _numbers("shifts_deg", self.shifts_deg)]
        return Gait(
            self.alpha_rad,
            self.beta_rad,
            self.omega_rad_s,
            self.offset_rad,
            tuple(gains),
            tuple(shifts),
        )

    @property
    def mean_gain(self) -> float:
        """Return the joints' mean amplitude over the commanded one."""
        gains = _numbers("gains", self.gains)
        return sum(gains) / len(gains)

    @property
    def gait_run(self) -> GaitRun:
        """Return the same as a gait run."""
        return GaitRun(
            self.number,
            self.alpha_rad,
            self.beta_rad,
            self.omega_rad_s,
            self.speed_m_s,
            self.speed_sigma_m_s,
            self.voided,
            self.comment or "film",
            self.time_utc,
            way=self.way,
        )

    def in_words(self) -> tuple[str, str]:
        """Return what it is, and its values."""
        alpha, beta = math.degrees(self.alpha_rad), math.degrees(self.beta_rad)
        what = f"film {alpha:.3g}°/{beta:.3g}°, {self.omega_rad_s / (2 * math.pi):.3g} Hz"
        return what, (
            f"{self.speed_m_s:.5f} ± {self.speed_sigma_m_s:.5f} m/s, "
            f"joints {100 * self.mean_gain:.1f} %"
        )


def _numbers(name: str, text: str) -> list[float]:
    try:
        return [float(part) for part in text.split(",")]
    except ValueError:
        raise BadInput(f"{name} is {text!r}; it must be numbers between commas") from None
