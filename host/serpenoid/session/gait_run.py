"""The crawling robot: the kinds `gait`, timed between marks, and `video`, measured in a film."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from statistics import mean
from typing import Any

from ..base.errors import BadInput
from ..model.gait import Gait, gait_name
from .declaration import Observation, number_field, word_field
from .settings import MAX_SPEED_M_S, Instruments
from .track import Track


@dataclass(frozen=True)
class Crawl(Observation):
    """One measured speed of the crawling robot, on level ground of the session's surface.

    omega_rad_s: the true rate, by the board's clock or the film. speed_m_s: of the robot over
    ground, 0 where it got nowhere. way: along the line of the pushes, on a floor that may slope, or
    on level ground.
    """

    alpha_rad: float = number_field(0.0, 180.0)
    beta_rad: float = number_field(-360.0, 360.0)
    omega_rad_s: float = number_field(0.0, 1000.0, open_low=True)
    speed_m_s: float = number_field(0.0, MAX_SPEED_M_S)
    speed_sigma_m_s: float = number_field(0.0, MAX_SPEED_M_S, open_low=True)
    way: str = word_field("level", "there", "back")

    @property
    def commanded(self) -> Gait:
        """Return the gait that was commanded, at its true rate."""
        return Gait(self.alpha_rad, self.beta_rad, self.omega_rad_s)

    @property
    def gait(self) -> Gait:
        """Return the gait that the joints made, as far as anybody saw."""
        return self.commanded


@dataclass(frozen=True)
class GaitRun(Crawl):
    """A crawl that was timed over a marked distance.

    distance_m, duration_s: what the speed follows from, None where it was given itself. Raises
    BadInput.
    """

    kind = "gait"

    distance_m: float | None = number_field(
        0.0, 1000.0, words="distance between the marks", default=None, likely=(0.05, 10.0)
    )
    duration_s: float | None = number_field(
        0.0, 1e5, words="time taken", default=None, likely=(1.0, 600.0), open_low=True
    )

    @classmethod
    def derived(cls, cells: dict[str, Any], watch: Instruments) -> dict[str, Any]:
        """Put in the speed that distance and time give, unless it is given itself."""
        columns = "distance_m", "duration_s"
        missing = [column for column in columns if column not in cells]
        if len(missing) == len(columns) or "speed_m_s" in cells:
            return cells
        if missing:
            raise BadInput(f"a gait run needs {' and '.join(columns)}; {missing[0]} is missing")
        speed, sigma = watch.speed(*(float(cells[column]) for column in columns))
        return {"speed_m_s": speed, "speed_sigma_m_s": sigma} | cells

    def in_words(self) -> tuple[str, str]:
        """Return (title, values) for tables."""
        return f"gait {gait_name(self.commanded)}", (
            f"{self.speed_m_s:.4f} ± {self.speed_sigma_m_s:.4f} m/s"
        )


@dataclass(frozen=True)
class FilmReading(Crawl):
    """A crawl as a film showed it.

    alpha_rad, beta_rad: commanded, or where nobody told, the mean of what was seen. offset_rad:
    seen. gains, shifts_deg: of every joint beside the commanded sine, tail first, between commas:
    amplitude as a factor, phase in degrees. film_sha256: of the film's file. Raises BadInput.
    """

    kind = "video"
    columns = ("t_s", "x_m", "y_m", "heading_rad", "joint*_rad")

    offset_rad: float = number_field(-180.0, 180.0, default=0.0)
    gain_sigma: float = number_field(0.0, 2.0, default=0.0)
    gains: str = word_field()
    shifts_deg: str = word_field()
    film_sha256: str = word_field()
    track: Track | None = None

    def __post_init__(self) -> None:
        _ = self._joints

    @property
    def gait(self) -> Gait:
        """Return the gait that the joints made."""
        gains, shifts = self._joints
        return replace(
            self.commanded,
            offset_rad=self.offset_rad,
            joint_gain=tuple(gains),
            joint_shift_rad=tuple(map(math.radians, shifts)),
        )

    @property
    def _joints(self) -> tuple[list[float], list[float]]:
        """Return gains and shifts, degrees, one a joint; raises BadInput."""
        try:
            gains, shifts = (
                [float(part) for part in text.split(",")] for text in (self.gains, self.shifts_deg)
            )
        except ValueError:
            gains, shifts = [], [0.0]
        if len(gains) != len(shifts):
            raise BadInput(
                f"gains is {self.gains!r} and shifts_deg {self.shifts_deg!r}; they must be one "
                "number a joint each, between commas"
            )
        return gains, shifts

    def in_words(self) -> tuple[str, str]:
        """Return title and values."""
        return f"film {gait_name(self.commanded)}", (
            f"{self.speed_m_s:.5f} ± {self.speed_sigma_m_s:.5f} m/s, "
            f"joints {100 * mean(self.gait.joint_gain):.1f} %"
        )
