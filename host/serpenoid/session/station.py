"""Readings taken at a treadmill: stations, and checks of the instruments that they are read with.

Their kinds in readings.csv are `station`, `zero`, `bend` and `belt`.
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

# Belt speed below which stations are biased: each correction of the steering shakes loose wheels
# that would stick, so that dry friction across comes out smaller than that of sliding wheels.
MIN_SLIP_M_S = 0.12


@dataclass(frozen=True)
class Reading(Observation):
    """One station held: the belt speed at which the snake neither climbs nor slides.

    lambda_rad: angle of a bent link to the direction of the belt; 0 when straight.
    bend: "zigzag", all links bent, alternately left and right (Eq. 60), or "balanced"
    (`model.bends`), in which the robot stays on course unguided.
    incline_rad: the incline gamma as the inclinometer shows it.
    belt_speed_m_s: speed of the belt, which runs uphill under a snake that faces downhill, so that
    its wheels roll forwards.
    drift_m_s: remaining velocity of the snake over the ground, positive when the belt carries it
    along.
    turned_rad: heading of the snake off the belt's direction; None if it was not recorded.
    offset_rad: steering angle added to every joint; None if it was not recorded.
    track: positions of the robot during a short reading, x uphill, while it still drifted;
    drift_m_s is then its mean velocity.

    Raises BadInput if the belt does not slip past the snake.
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
        """Return the speed of the belt past the snake, m/s: v_rel = v_belt - v_drift."""
        return self.belt_speed_m_s - self.drift_m_s

    @classmethod
    def derived(cls, cells: dict[str, Any], watch: Instruments) -> dict[str, Any]:
        """Return the cells with the mean drift, m/s, of a short reading."""
        if PLACES not in cells:
            return cells
        track = typed_track(str(cells[PLACES]))
        duration_s, distance_m, _ = track[-1]
        return cells | {"drift_m_s": float(distance_m / duration_s)}

    def in_words(self) -> tuple[str, str]:
        """Return (title, values) for tables."""
        values = (
            f"{math.degrees(self.incline_rad):.2f}°, belt {self.belt_speed_m_s:.3f}, "
            f"drift {self.drift_m_s + 0.0:+.3f} m/s"
            + (f", turned {math.degrees(self.turned_rad):+.3g}°" if self.turned_rad else "")
        )
        zigzag = " as a zigzag" if self.bend == "zigzag" and self.lambda_rad else ""
        bend = f"bend {math.degrees(self.lambda_rad):.4g}°" if self.lambda_rad else "straight"
        return f"station, {bend}{zigzag}", values


@dataclass(frozen=True)
class ZeroReading(Observation):
    """The inclinometer read twice on one spot, the second time turned end for end.

    The two inclines cancel in the sum, which leaves twice the zero error.
    incline_rad, reversed_rad: the angles shown first, and after the turn.
    at_start: whether it was read before the first station.
    """

    kind = "zero"
    fitted = True

    incline_rad: float = number_field(
        -MAX_INCLINE_DEG, MAX_INCLINE_DEG, words="it shows", likely=(-5.0, 5.0)
    )
    reversed_rad: float = number_field(
        -MAX_INCLINE_DEG,
        MAX_INCLINE_DEG,
        words="turned, it shows",
        likely=(-5.0, 5.0),
        why="the zero would be beyond 0.5 deg: was a sign forgotten?",
    )
    at_start: bool = True

    @property
    def zero_rad(self) -> float:
        """Return the angle that the inclinometer shows on level ground, rad."""
        return (self.incline_rad + self.reversed_rad) / 2

    def in_words(self) -> tuple[str, str]:
        """Return (title, values) for tables."""
        shown, turned = math.degrees(self.incline_rad), math.degrees(self.reversed_rad)
        values = f"{shown:+.2f}°, turned {turned:+.2f}°: zero {math.degrees(self.zero_rad):+.3f}°"
        return f"inclinometer, {'before' if self.at_start else 'after'}", values


@dataclass(frozen=True)
class BendCheck(Observation):
    """The protractor held between the last two links at an end of a bent robot.

    The joint between them is at 2 lambda in either bend, zigzag or balanced.
    lambda_rad: the planned bend. between_links_rad: the angle shown, pi - 2 lambda.
    """

    kind = "bend"

    lambda_rad: float = number_field(0.0, MAX_LAMBDA_DEG)
    between_links_rad: float = number_field(0.0, 180.0, words="the protractor shows")
    bend: str = word_field(*BENDS)

    @property
    def found_rad(self) -> float:
        """Return lambda from the protractor's angle, rad."""
        return (math.pi - self.between_links_rad) / 2

    def in_words(self) -> tuple[str, str]:
        """Return (title, values) for tables."""
        between_deg, lambda_deg = map(math.degrees, (self.between_links_rad, self.found_rad))
        values = f"{between_deg:.4g}° between links: λ = {lambda_deg:.4g}°"
        return f"protractor, bend {math.degrees(self.lambda_rad):.4g}°", values


@dataclass(frozen=True)
class BeltCheck(Observation):
    """A mark on the belt, timed over a distance: it gives the belt's true speed.

    belt_speed_m_s: the speed that the treadmill shows. distance_m: distance that the mark travelled
    in duration_s. Raises BadInput if the true speed is too far from the one shown.
    """

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
        words="distance that the mark travelled (turns of the belt times its length)",
        open_low=True,
    )
    duration_s: float = number_field(
        0.0, 1e5, words="time taken", likely=(5.0, 600.0), open_low=True
    )

    def __post_init__(self) -> None:
        low, high = 0.5, 2.0  # Limits beyond which a unit was mistaken
        if not self.voided and not low < self.scale < high:
            raise BadInput(
                f"the belt ran {self.scale:.3g} times as fast as it showed in reading "
                f"{self.number}; it must be {low:g} to {high:g}; check the "
                "units, and count all turns"
            )

    @property
    def scale(self) -> float:
        """Return the ratio of the belt's true speed to the one shown."""
        return self.distance_m / self.duration_s / self.belt_speed_m_s

    def scale_sigma(self, watch: Instruments) -> float:
        """Return the standard deviation of the scale from the errors of tape and stopwatch."""
        speed_m_s, sigma_m_s = watch.speed(self.distance_m, self.duration_s)
        return self.scale * sigma_m_s / speed_m_s

    def in_words(self) -> tuple[str, str]:
        """Return (title, values) for tables."""
        return "belt check", (
            f"{self.distance_m:.4g} m in {self.duration_s:.4g} s at {self.belt_speed_m_s:.4g} m/s "
            f"shown: true speed {self.scale:.4g} times the one shown"
        )


def bent_share(bend: str, links: int) -> float:
    """Return the share of a robot's links that are bent, 0 to 1.

    Raises BadInput if so few links have no balanced bend.
    """
    if bend == "zigzag":
        return 1.0
    signs = balanced_signs(links)
    return sum(map(abs, signs)) / links


def slips(bend: str, angle: float, links: int) -> bool:
    """Return whether a bent robot may slide sideways: no straight link and no guide prevents it.

    angle: lambda of the bend, in any unit; 0 if the robot is straight.
    """
    return bend == "balanced" and angle > 0.0 and bent_share(bend, links) == 1.0
