"""How fast a film's time ran: pictures a second that the camera took, over those that are played.

A phone's slow motion holds 30 pictures for each second in a player, taken at 120 or 240 a second.
Its camera then multiplied each time by 4 or 8, also where it dropped pictures: what counts is the
rate that a player is told, not how many pictures there are. A track that was marked in each eighth
picture only has the times of such a film, too.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from statistics import median
from typing import Any

from ..base.errors import BadInput

OPTION = "--capture-fps"


@dataclass(frozen=True)
class FilmRates:
    """Rates of films, in pictures a second.

    played_hz: those that players show. error: relative error of a rate: 29.97 and 30.04 are 30.
    slowest_hz: below it nothing is played: cameras drop pictures in dim light, and people mark each
    fourth one; then usual_hz is played. dropped: a camera that took up to so many times the rate
    that is played dropped pictures; above, it took slow motion. highest_hz: of any camera.
    """

    played_hz: tuple[float, ...] = (24.0, 25.0, 30.0, 50.0, 60.0, 90.0, 120.0, 240.0, 480.0, 960.0)
    error: float = 0.04
    slowest_hz: float = 23.0
    usual_hz: float = 30.0
    dropped: float = 1.5
    highest_hz: float = 10_000.0


RATES = FilmRates()


@dataclass(frozen=True)
class CaptureRate:
    """A film's two rates, in pictures a second, and who says what the camera took."""

    taken_hz: float
    played_hz: float
    source: str

    @property
    def stated(self) -> bool:
        """Tell whether a person says so, not a tag."""
        return self.source.startswith(OPTION)

    @property
    def time_scale(self) -> float:
        """Return what the file's times are multiplied with to be real ones."""
        ratio = self.taken_hz / self.played_hz
        if ratio < RATES.dropped:
            return 1.0
        integer = round(ratio)
        return 1.0 / (integer if abs(ratio / integer - 1.0) < RATES.error else ratio)

    def in_words(self) -> str:
        """Return what was made of them, and what to do if that is wrong."""
        rates = (
            f"{self.source} says that the camera took {self.taken_hz:g} pictures a second, and the "
            f"file plays {self.played_hz:g}"
        )
        if self.time_scale == 1.0:
            return f"{rates}: its times are real"
        return (
            f"{rates}: its times are divided by {1.0 / self.time_scale:.4g}, and all that follows "
            f"is in real time. If they were real before, give --capture-fps {self.played_hz:g}"
        )


def capture_rate(t_s: Any, taken_hz: float, source: str) -> CaptureRate:
    """Return a film's rates, from its pictures' times (K,), s, as the file has them.

    taken_hz: what the camera took a second; source: who says so. Raises BadInput where the file
    plays more than that: a time lapse, or a wrong number.
    """
    if not 0.0 < taken_hz <= RATES.highest_hz:
        raise BadInput(
            f"{source} says that the camera took {taken_hz:g} pictures a second; that is between 1 "
            f"and {RATES.highest_hz:g}: give the rate with --capture-fps"
        )
    file_hz = played_hz(t_s)
    if taken_hz * RATES.dropped < file_hz:
        raise BadInput(
            f"{source} says that the camera took {taken_hz:g} pictures a second, and the file "
            f"plays {file_hz:g}: is it a time lapse? Film at normal speed, or give the camera's "
            "rate with --capture-fps"
        )
    return CaptureRate(taken_hz, file_hz, source)


def slow_motion_doubt(t_s: Any) -> str:
    """Return what to ask where times (K,), s, are sparser than pictures of a film; else ""."""
    rate_hz = _rate_hz(t_s)
    if rate_hz >= RATES.slowest_hz:
        return ""
    return (
        f"{rate_hz:.3g} places a second, and films have 24 or more. If it was made of a film in "
        f"slow motion, give the camera's pictures a second: `serpenoid calibrate push`, {OPTION}"
    )


def _rate_hz(t_s: Any) -> float:
    times_s = sorted(map(float, t_s))
    gaps_s = [end - start for start, end in pairwise(times_s) if end > start]
    return 1.0 / median(gaps_s) if gaps_s else RATES.usual_hz


def played_hz(t_s: Any) -> float:
    """Return how many pictures a second a player is told to show, from their times (K,), s."""
    rate_hz = _rate_hz(t_s)
    nearest = min(RATES.played_hz, key=lambda known_hz: abs(known_hz - rate_hz))
    if abs(rate_hz / nearest - 1.0) < RATES.error:
        return nearest
    return RATES.usual_hz if rate_hz < RATES.slowest_hz else rate_hz
