"""The kind `push`: a push along a floor, after which the robot rolls out and comes to rest."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from ..base.errors import BadInput
from .declaration import DERIVED, Field, Taken, Word
from .push_size import unlikely_push, unlikely_sigma
from .station import BEND_WORD, LAMBDA, STEERING, bend_in_words
from .track import Floats, Track

WAYS = ("there", "back")
SOURCES = ("rest", "film")  # what a push is known by: tape and watch, or a table of places
TRACK = ("t_s", "x_m", "y_m")


@dataclass(frozen=True, slots=True)
class Push(Taken):
    """One push: the robot let go at speed on a level floor, and followed until it rests.

    number: from 1, unique in a session. lambda_rad, bend: as of a station. way: "there" or "back"
    along one line of the floor, so that its slope cancels. place: of the line, where there are more
    than one. by: "film" (track: where the robot was in every picture) or "rest" (distance_m and
    duration_s alone). start_s, end_s: what part of the track counts. scale_sigma: of all lengths of
    a film, relative, where its tags tell it; one scale for all films, as of one sheet of tags.
    distance_sigma_m, time_sigma_s: of one place and one time; None: those of the set-up.
    offset_rad: steering on every joint; None where nobody told. file_sha256: of the file that the
    track came from. Raises BadInput.
    """

    kind = "push"
    fitted = True
    track_may_miss = True
    columns = TRACK
    fields = (
        LAMBDA,
        Field(
            "distance_m",
            "way from where the hand let go to where it rests",
            0.0,
            100.0,
            (0.2, 5.0),
            "push harder: a short way tells little",
            open_low=True,
            optional=True,
        ),
        Field(
            "duration_s",
            "time from the hand to rest",
            0.0,
            1e3,
            (0.4, 20.0),
            open_low=True,
            optional=True,
        ),
        Field(
            "turned_deg",
            "turned while it rolled, + to the left (Enter: not)",
            -180.0,
            180.0,
            likely=(-10.0, 10.0),
            usual=0.0,
            optional=True,
            why="a robot that turns by more slips sideways: push it again",
        ),
        Field(
            "start_s",
            "the track counts from here, the hand gone",
            -1e6,
            1e6,
            source=DERIVED,
            optional=True,
        ),
        Field("end_s", "the track counts to here", -1e6, 1e6, source=DERIVED, optional=True),
        Field(
            "scale_sigma",
            "standard deviation of the film's scale, relative",
            0.0,
            0.2,
            source=DERIVED,
            optional=True,
        ),
        Field(
            "distance_sigma_m",
            "standard deviation of a place",
            0.0,
            100.0,
            open_low=True,
            source=DERIVED,
            optional=True,
        ),
        Field(
            "time_sigma_s",
            "standard deviation of a time",
            0.0,
            10.0,
            source=DERIVED,
            optional=True,
        ),
        STEERING,
        Word("way", WAYS),
        Word("by", SOURCES, source=DERIVED),
        BEND_WORD,
        Word("place"),
        Word("file_sha256", source=DERIVED),
    )

    number: int
    lambda_rad: float
    distance_m: float | None = None
    duration_s: float | None = None
    turned_rad: float | None = None
    start_s: float | None = None
    end_s: float | None = None
    scale_sigma: float | None = None
    distance_sigma_m: float | None = None
    time_sigma_s: float | None = None
    way: str = "there"
    by: str = "rest"
    bend: str = "zigzag"
    place: str = ""
    file_sha256: str = ""
    track: Track | None = None
    voided: bool = False
    comment: str = ""
    time_utc: str = ""
    offset_rad: float | None = field(default=None, repr=False)  # no part of the session's hash

    def __post_init__(self) -> None:
        if self.track is None and (self.by != "rest" or None in (self.distance_m, self.duration_s)):
            raise BadInput(
                f"push {self.number} has neither a track nor distance_m and duration_s; give a "
                "film, or the way and the time to rest"
            )
        if self.track is not None and self.by == "rest":
            raise BadInput(f"push {self.number} has a track; say by=film")
        if self.track is not None and len(self.counted[0]) < 3:
            raise BadInput(
                f"push {self.number} has {len(self.counted[0])} sample(s) between start_s and "
                "end_s; three at least"
            )

    def doubt(self) -> str:
        """Return why it is no push: too fast, too long, or places too uncertain."""
        if self.distance_sigma_m is not None and (told := unlikely_sigma(self.distance_sigma_m)):
            return told
        if self.distance_m is None or not self.duration_s:
            return ""
        # Dry friction alone brakes evenly: the speed at the start is twice the mean one.
        return unlikely_push(2 * self.distance_m / self.duration_s, self.distance_m)

    @property
    def counted(self) -> Floats:
        """Return t_s, x_m and y_m of the samples that count, (3, samples)."""
        if self.track is None:
            return np.empty((3, 0))
        t = self.track.values[:, 0]
        low = -math.inf if self.start_s is None else self.start_s - 1e-9
        high = math.inf if self.end_s is None else self.end_s + 1e-9
        return self.track.values[(low <= t) & (t <= high)].T

    def in_words(self) -> tuple[str, str]:
        """Return what it is, and its values."""
        bend = bend_in_words(self.lambda_rad)
        where = f" at {self.place}" if self.place else ""
        what = f"push {self.way}{where}{bend}"
        if self.track is None:
            return what, f"{self.distance_m:.3f} m in {self.duration_s:.2f} s to rest"
        t, x, y = self.counted
        way = math.hypot(x[-1] - x[0], y[-1] - y[0])
        turned = f", turned {math.degrees(self.turned_rad):+.2g}°" if self.turned_rad else ""
        return what, f"{self.by}: {len(t)} places, {way:.3f} m in {t[-1] - t[0]:.2f} s{turned}"
