"""The instruments of a session: what they may be off by, and what they can be set to."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

from ..base.checks import check_number

MAX_SPEED_M_S = 10.0  # no treadmill runs faster: beyond it a number is a slip of units


class _Instruments:
    """Numbers of instruments; raises BadInput for one that is negative or NaN."""

    __slots__ = ()

    def __post_init__(self) -> None:
        for field in fields(self):  # type: ignore[arg-type]
            if (value := getattr(self, field.name)) is not None:
                check_number(field.name, value, 0.0)


@dataclass(frozen=True, slots=True)
class Uncertainty(_Instruments):
    """What the instruments may be off by, as standard deviations.

    incline_sigma_rad: of one reading of the inclinometer. incline_zero_sigma_rad: of its zero,
    common to the session. belt_speed_sigma_m_s: of one belt speed past the snake.
    lambda_sigma_rad: of the bend, common to all bent readings. Common to all readings, too:
    belt_scale_sigma and mass_sigma, of the belt's true speed over the one shown and of the robot's
    true mass over the one stated (0.02 is 2 %), and joint_sigma_rad, of each joint about straight.
    0 takes them for exact.
    """

    incline_sigma_rad: float
    incline_zero_sigma_rad: float
    belt_speed_sigma_m_s: float
    lambda_sigma_rad: float
    belt_scale_sigma: float = 0.0
    mass_sigma: float = 0.0
    joint_sigma_rad: float = 0.0


@dataclass(frozen=True, slots=True)
class TreadmillSteps(_Instruments):
    """What a treadmill can be set to: most home ones by 0.5 % of grade and 0.1 km/h."""

    incline_step_rad: float = 0.005
    belt_step_m_s: float = 0.1 / 3.6
    belt_least_m_s: float = 0.0


@dataclass(frozen=True, slots=True)
class Stopwatch(_Instruments):
    """Standard deviations of a gait run's distance (tape and marks) and time (a hand's)."""

    distance_sigma_m: float = 0.005
    time_sigma_s: float = 0.2

    def speed(self, distance_m: float, time_s: float) -> tuple[float, float]:
        """Return the mean speed over a distance and its standard deviation, m/s."""
        speed_m_s = distance_m / time_s
        off_m = math.hypot(self.distance_sigma_m, speed_m_s * self.time_sigma_s)
        return speed_m_s, off_m / time_s


@dataclass(frozen=True, slots=True)
class FloorTools(_Instruments):
    """What a push is measured with, as standard deviations, and what its wheels weigh.

    wheels_kg: mass of all wheels together, whose turning takes part of a push; None: not told.
    film_scale_sigma: of all lengths in films, relative. push_time_sigma_s: of a time taken by hand.
    slope_sigma_rad: of the slope of a floor, before both ways tell it.
    """

    wheels_kg: float | None = None
    film_scale_sigma: float = 0.005
    push_time_sigma_s: float = 0.12
    slope_sigma_rad: float = math.radians(0.3)
