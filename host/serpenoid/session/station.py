"""What is read at a treadmill: stations held, and checks of what they are read with.

The kinds `station`, `zero`, `bend` and `belt`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from ..base.errors import BadInput
from ..model.bends import BENDS, balanced_signs
from .declaration import Observation, number_field, word_field
from .settings import MAX_INCLINE_DEG, MAX_LAMBDA_DEG, MAX_SPEED_M_S, Instruments
from .track import PLACES, TRACK, Track, typed_track

# Slower than this a robot that is steered goes by jerks: every touch of the steering shakes wheels
# loose that would rest, so that dry friction across is less than that of wheels which slide.
LEAST_SLIP_M_S = 0.12
BELT_SCALES = (0.5, 2.0)  # true speed over the one shown: beyond them a unit is mistaken
LIKELY_DEG = (-5.0, 5.0)  # readings of an inclinometer that is turned end for end


@dataclass(frozen=True)
class Reading(Observation):
    """One station held: the belt speed at which the snake neither climbs nor slides.

    lambda_rad: angle of a bent link to the direction of the
    belt; 0 when straight. bend: "zigzag", all links bent, alternately left and right (Eq. 60), or
    "balanced" (`model.bends`), where the robot stays on course unguided. incline_rad: gamma as the
    inclinometer shows it. belt_speed_m_s: uphill, so that the snake, facing downhill, rolls
    forwards. drift_m_s: what was left of the snake's own motion, positive when carried along with
    the belt. turned_rad: heading when it was read. offset_rad: steering on every joint;
    each None where nobody told. track: of a short reading, where the robot was, x uphill, while it
    still drifted; the drift is then the mean. Raises BadInput.
    """

    kind = "station"
    fitted = True
    columns = TRACK
    track_may_miss = True

    lambda_rad: float = number_field(0.0, MAX_LAMBDA_DEG, words="the bend")
    incline_rad: float = number_field(
        0.0, MAX_INCLINE_DEG, words="the inclinometer shows", open_low=True
    )
    belt_speed_m_s: float = number_field(0.0, MAX_SPEED_M_S, words="belt speed")
    drift_m_s: float = number_field(
        -MAX_SPEED_M_S,
        MAX_SPEED_M_S,
        words="drift left over, + uphill with the belt (Enter: none)",
        default=0.0,
        likely=(-0.06, 0.06),
        usual=0.0,
    )
    bend: str = word_field(*BENDS)
    turned_rad: float | None = number_field(
        -180.0,
        180.0,
        words="turned off the belt's direction, + to the left (Enter: not)",
        default=None,
        likely=(-5.0, 5.0),
        usual=0.0,
        why="a robot that has turned by more is not held by this law: hold it again",
    )
    offset_rad: float | None = number_field(-45.0, 45.0, default=None)
    track: Track | None = None

    def __post_init__(self) -> None:
        if not self.voided and self.slip_speed_m_s <= 0.0:
            raise BadInput(
                f"belt_speed_m_s - drift_m_s is {self.slip_speed_m_s:g} in reading {self.number}; "
                "it must be more than 0, since wheels at rest hold any force up to their static "
                "friction; void the reading or correct it"
            )

    @property
    def slip_speed_m_s(self) -> float:
        """Return the speed of the belt past the snake, v_rel = v_belt - v_drift."""
        return self.belt_speed_m_s - self.drift_m_s

    @classmethod
    def derived(cls, cells: dict[str, Any], watch: Instruments) -> dict[str, Any]:
        """Put in the mean drift of a short reading."""
        if PLACES not in cells:
            return cells
        duration_s, way_m, _ = typed_track(str(cells[PLACES]))[-1]
        return cells | {"drift_m_s": float(way_m / duration_s)}

    def in_words(self) -> tuple[str, str]:
        """Return what it is, and its values."""
        values = (
            f"{math.degrees(self.incline_rad):.2f}°, belt {self.belt_speed_m_s:.3f}, "
            f"drift {self.drift_m_s + 0.0:+.3f} m/s"
            + (f", turned {math.degrees(self.turned_rad):+.3g}°" if self.turned_rad else "")
        )
        zigzag = " as a zigzag" if self.bend == "zigzag" and self.lambda_rad else ""
        return f"station, bend {math.degrees(self.lambda_rad):.4g}°{zigzag}", values


@dataclass(frozen=True)
class ZeroReading(Observation):
    """The inclinometer read twice on one spot, the second time turned end for end.

    What stays of the sum is twice its zero. at_start: taken before the first station.
    """

    kind = "zero"
    fitted = True

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
    at_start: bool = True

    @property
    def zero_rad(self) -> float:
        """Return what the inclinometer shows where it is level."""
        return (self.incline_rad + self.reversed_rad) / 2

    def in_words(self) -> tuple[str, str]:
        """Return what it is, and its values."""
        shown, turned = math.degrees(self.incline_rad), math.degrees(self.reversed_rad)
        values = f"{shown:+.2f}°, turned {turned:+.2f}°: zero {math.degrees(self.zero_rad):+.3f}°"
        return f"inclinometer, {'before' if self.at_start else 'after'}", values


@dataclass(frozen=True)
class BendCheck(Observation):
    """The protractor held between the last two links at an end of a bent robot.

    There a joint stands at 2 lambda in either bend, zigzag or balanced.
    """

    kind = "bend"

    lambda_rad: float = number_field(0.0, MAX_LAMBDA_DEG)
    between_links_rad: float = number_field(0.0, 180.0, words="the protractor shows")
    bend: str = word_field(*BENDS)

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
class BeltCheck(Observation):
    """A mark on the belt, timed over a way: the true speed over the one that was shown."""

    kind = "belt"
    fitted = True

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

    def __post_init__(self) -> None:
        if not self.voided and not BELT_SCALES[0] < self.scale < BELT_SCALES[1]:
            raise BadInput(
                f"the belt ran {self.scale:.3g} times as fast as it showed in reading "
                f"{self.number}; it must be {BELT_SCALES[0]:g} to {BELT_SCALES[1]:g}; check the "
                "units, and count all turns"
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


def bent_share(bend: str, links: int) -> float:
    """Return which share of a robot's links is bent; raises BadInput where none can be."""
    if bend == "zigzag":
        return 1.0
    return sum(map(abs, balanced_signs(links))) / links


def slips(bend: str, angle: float, links: int) -> bool:
    """Tell whether a bent robot has no straight link, and no guide, that holds it on its path.

    angle: of the bend, in any unit; 0: it is straight.
    """
    return bend == "balanced" and angle > 0.0 and bent_share(bend, links) == 1.0
