"""Readings of kind `push`: a push along a floor, after which the robot rolls to a stop."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..base.checks import count_text
from ..base.errors import BadInput
from ..model.bends import BENDS
from .declaration import Observation, number_field, word_field
from .settings import MAX_LAMBDA_DEG, MAX_PLACE_SIGMA_M, Instruments
from .track import TRACK, Floats, Track

WAYS = ("there", "back")


@dataclass(frozen=True)
class Push(Observation):
    """One push: the robot is released at speed on a level floor, and rolls to a stop.

    lambda_rad, bend: as of a station. distance_m, duration_s: from the hand to rest. turned_rad:
    change of heading. way: "there" or "back" along one line of the floor, so that its slope
    cancels. place: name of the line, if there are several. source: "film" if there is a track of
    positions, "rest" for distance_m and duration_s alone. start_s, end_s: the part of the track
    that counts. scale_sigma: relative sigma of all lengths in films, shared by all, from the tags.
    distance_sigma_m, time_sigma_s: sigmas of a position and a time; None: those of the set-up.
    offset_rad: steering angle on every joint; None if it was not recorded. file_sha256: hash of the
    track's file. Raises BadInput if neither track nor distance and duration are there.
    """

    kind = "push"
    fitted = True
    track_may_miss = True
    columns = TRACK

    lambda_rad: float = number_field(0.0, MAX_LAMBDA_DEG)
    distance_m: float | None = number_field(
        0.0,
        100.0,
        words="way from the hand to rest",
        default=None,
        likely=(0.2, 5.0),
        why="push harder: a short way tells little",
        open_low=True,
    )
    duration_s: float | None = number_field(
        0.0,
        1e3,
        words="time from the hand to rest",
        default=None,
        likely=(0.4, 20.0),
        open_low=True,
    )
    turned_rad: float | None = number_field(
        -180.0,
        180.0,
        words="turn, + to the left (Enter: none)",
        default=None,
        likely=(-10.0, 10.0),
        usual=0.0,
        why="a robot that turns by more slips sideways: push it again",
    )
    start_s: float | None = number_field(-1e6, 1e6, default=None)
    end_s: float | None = number_field(-1e6, 1e6, default=None)
    scale_sigma: float | None = number_field(0.0, 0.2, default=None)
    distance_sigma_m: float | None = number_field(
        0.0, MAX_PLACE_SIGMA_M, default=None, open_low=True
    )
    time_sigma_s: float | None = number_field(0.0, 10.0, default=None)
    way: str = word_field(*WAYS)
    source: str = word_field("rest", "film", column="by")
    bend: str = word_field(*BENDS)
    place: str = word_field()
    file_sha256: str = word_field()
    track: Track | None = None
    offset_rad: float | None = number_field(-45.0, 45.0, default=None, shown=False)

    def __post_init__(self) -> None:
        if self.track is None and (
            self.source != "rest" or None in (self.distance_m, self.duration_s)
        ):
            raise BadInput(
                f"push {self.number} has neither a track nor distance_m and duration_s; give a "
                "film, or the way and the time to rest"
            )
        if self.track is not None and self.source == "rest":
            raise BadInput(f"push {self.number} has a track; say by=film")
        count, min_count = len(self.counted[0]), 3  # Fewest positions that show a deceleration.
        if self.track is not None and count < min_count:
            raise BadInput(
                f"push {self.number} has {count_text(count, 'sample')} between start_s and end_s; "
                f"{min_count} at least"
            )

    @classmethod
    def derived(cls, cells: dict[str, Any], watch: Instruments) -> dict[str, Any]:
        """Return the cells as they are; raises BadInput for a push too fast or too long."""
        if "distance_m" in cells and cells.get("duration_s"):
            distance_m = float(cells["distance_m"])
            # With dry friction alone the initial speed is twice the mean speed.
            check_push(2 * distance_m / float(cells["duration_s"]), distance_m)
        return cells

    @property
    def counted(self) -> Floats:
        """Return t_s, x_m and y_m of the track between start_s and end_s, (3, samples)."""
        if self.track is None:
            return np.empty((3, 0))
        t = self.track.values[:, 0]
        low = -math.inf if self.start_s is None else self.start_s - 1e-9
        high = math.inf if self.end_s is None else self.end_s + 1e-9
        return self.track.values[(low <= t) & (t <= high)].T

    def in_words(self) -> tuple[str, str]:
        """Return (title, values) for tables."""
        angle = math.degrees(self.lambda_rad)
        bend = f", bend {angle:.4g}°" if angle else ", straight"
        where = f" at {self.place}" if self.place else ""
        what = f"push {self.way}{where}{bend}"
        if self.track is None:
            return what, f"{self.distance_m:.3f} m in {self.duration_s:.2f} s to rest"
        t, x, y = self.counted
        way = math.hypot(x[-1] - x[0], y[-1] - y[0])
        turned = f", turned {math.degrees(self.turned_rad):+.2g}°" if self.turned_rad else ""
        return what, f"{self.source}: {len(t)} places, {way:.3f} m in {t[-1] - t[0]:.2f} s{turned}"


def check_push(speed_m_s: float, way_m: float) -> None:
    """Raise BadInput if a push is too fast or too long to be one."""
    max_m_s, max_m = 3.0, 10.0  # Usual pushes have 0.3 to 1.5 m/s.
    if speed_m_s > max_m_s or way_m > max_m:
        raise BadInput(
            f"{way_m:.3g} m from {speed_m_s:.3g} m/s is no push: at most {max_m:g} m and "
            f"{max_m_s:g} m/s; is its unit right?"
        )
