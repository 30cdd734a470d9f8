"""Readings of the crawling robot: kind `gait`, timed between marks, and `video`, from a film."""

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
    """One measured speed of the crawling robot on the session's surface.

    alpha_rad, beta_rad: the commanded amplitude and phase lag. omega_rad_s: the true rate, by the
    board's clock or the film. speed_m_s, speed_sigma_m_s: speed over ground and its standard
    deviation. way: "level" for level ground; "there" or "back", the direction along the line of the
    pushes, for a floor that may slope.
    """

    alpha_rad: float = number_field(0.0, 180.0)
    beta_rad: float = number_field(-360.0, 360.0)
    omega_rad_s: float = number_field(0.0, 1000.0, open_low=True)
    speed_m_s: float = number_field(0.0, MAX_SPEED_M_S)
    speed_sigma_m_s: float = number_field(0.0, MAX_SPEED_M_S, open_low=True)
    way: str = word_field("level", "there", "back")

    @property
    def commanded(self) -> Gait:
        """Return the commanded gait, at its true rate."""
        return Gait(self.alpha_rad, self.beta_rad, self.omega_rad_s)

    @property
    def gait(self) -> Gait:
        """Return the gait of the joints: as filmed, else as commanded."""
        return self.commanded


@dataclass(frozen=True)
class GaitRun(Crawl):
    """A crawl that was timed over a marked distance.

    distance_m, duration_s: distance and time of the measured speed; None if the speed was entered.
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
        """Return the cells with the speed from distance and time, unless they have a speed."""
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
    """A crawl measured in a film.

    alpha_rad, beta_rad: as commanded; if unknown, the mean over the filmed joints. offset_rad: as
    filmed. gains, shifts_deg: for each joint from the tail, separated by commas: ratio of the
    filmed to the commanded amplitude, and phase relative to the command, deg. film_sha256: hash of
    the film's file. Raises BadInput if gains and shifts_deg do not fit each other.
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
        """Return the gait of the joints as filmed."""
        gains, shifts_rad = zip(*self._joints, strict=True)
        joints: dict[str, Any] = {"joint_gain": gains, "joint_shift_rad": shifts_rad}
        return replace(self.commanded, offset_rad=self.offset_rad, **joints)

    @property
    def _joints(self) -> list[tuple[float, float]]:
        """Return the gain and the phase shift, rad, of each joint; raises BadInput."""
        joints = zip(self.gains.split(","), self.shifts_deg.split(","), strict=True)
        try:
            return [(float(gain), math.radians(float(shift))) for gain, shift in joints]
        except ValueError as error:
            raise BadInput(
                f"gains is {self.gains!r} and shifts_deg {self.shifts_deg!r}; they must be one "
                "number a joint each, between commas"
            ) from error

    def in_words(self) -> tuple[str, str]:
        """Return (title, values) for tables."""
        return f"film {gait_name(self.commanded)}", (
            f"{self.speed_m_s:.5f} ± {self.speed_sigma_m_s:.5f} m/s, "
            f"joints {100 * mean(self.gait.joint_gain):.1f} %"
        )
