"""The kind `station`: the belt speed at which the snake holds its place on an incline."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from ..base.errors import BadInput
from ..model.bends import balanced_signs
from .declaration import PLANNED, Taken, number_field, word_field
from .instruments import MAX_INCLINE_DEG, MAX_LAMBDA_DEG, MAX_SPEED_M_S, Instruments
from .places import drifts, tidy_places

BENDS = ("zigzag", "balanced")  # zigzag first: sessions of before there were others do not say
# Slower than this a robot that is steered goes by jerks: every touch of the steering shakes wheels
# loose that would rest, so that dry friction across is less than that of wheels which slide.
LEAST_SLIP_M_S = 0.12


@dataclass(frozen=True)
class Reading(Taken):
    """One station held: the belt speed at which the snake neither climbs nor slides.

    number: from 1, unique in a session. lambda_rad: angle of a bent link to the direction of the
    belt; 0 when straight. bend: "zigzag", all links bent, alternately left and right (Eq. 60), or
    "balanced" (`model.bends`), where the robot stays on course unguided. incline_rad: gamma as the
    inclinometer shows it. belt_speed_m_s: uphill, so that the snake, facing downhill, rolls
    forwards. drift_m_s: what was left of the snake's own motion, positive when carried along with
    the belt. voided: not to be used, for the reason in comment. time_utc: ISO 8601, empty if not
    recorded. turned_rad: heading when it was read. offset_rad: steering on every joint.
    waited_s: how long the belt had run at this speed; each None where nobody told. places: of a
    short reading, where the robot was at some times while it still drifted (`kinds.places`); the
    drift is then the mean. Raises BadInput.
    """

    kind = "station"
    part = "readings"
    fitted = True

    number: int
    lambda_rad: float = number_field(0.0, MAX_LAMBDA_DEG, words="the bend", source=PLANNED)
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
    voided: bool = False
    comment: str = ""
    time_utc: str = ""
    bend: str = word_field(*BENDS, of_plan=True)
    turned_rad: float | None = number_field(
        -180.0,
        180.0,
        words="turned off the belt's direction, + to the left (Enter: not)",
        default=None,
        likely=(-5.0, 5.0),
        usual=0.0,
        why="a robot that has turned by more is not held by this law: hold it again",
    )
    offset_rad: float | None = number_field(-45.0, 45.0, default=None, source=PLANNED)
    waited_s: float | None = number_field(
        0.0, 1e5, words="time since the belt was set", default=None, source=PLANNED
    )
    places: str = word_field(tidy=tidy_places)

    def __post_init__(self) -> None:
        Taken.__post_init__(self)
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

    @property
    def drift_in_words(self) -> str:
        """Return the drift, m/s; of a short reading that of its start and of its end."""
        if not self.places:
            return f"{self.drift_m_s + 0.0:+.3f}"
        mean, change, _ = drifts(self.places)
        return f"{mean - change / 2:+.3f} to {mean + change / 2:+.3f}"

    def balance_sine(self, gravity_m_s2: float) -> float:
        """Return the sine of the incline at which the robot would hold its place at this slip.

        That of the reading's own incline, unless its drift changed meanwhile.
        """
        if not self.places:
            return math.sin(self.incline_rad)
        _, change_m_s, duration_s = drifts(self.places)
        return math.sin(self.incline_rad) + change_m_s / duration_s / gravity_m_s2

    @classmethod
    def derived(cls, cells: dict[str, Any], watch: Instruments) -> dict[str, Any]:
        """Put in the mean drift of a short reading."""
        places = str(cells.get("places", ""))
        return cells | {"drift_m_s": drifts(tidy_places(places))[0]} if places else cells

    def in_words(self) -> tuple[str, str]:
        """Return what it is, and its values."""
        values = (
            f"{math.degrees(self.incline_rad):.2f}°, belt {self.belt_speed_m_s:.3f}, "
            f"drift {self.drift_in_words} m/s"
            + (f", turned {math.degrees(self.turned_rad):+.3g}°" if self.turned_rad else "")
        )
        zigzag = " as a zigzag" if self.bend == "zigzag" and self.lambda_rad else ""
        return f"station, bend {math.degrees(self.lambda_rad):.4g}°{zigzag}", values


def bend_in_words(lambda_rad: float) -> str:
    """Return how the robot lies: ", bend 20°" or ", straight"."""
    return f", bend {math.degrees(lambda_rad):.4g}°" if lambda_rad else ", straight"


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
