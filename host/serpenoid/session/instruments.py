"""The instruments of a session: what they may be off by, and what they can be set to."""

from __future__ import annotations

import math
from dataclasses import dataclass

from .declaration import BELT_UNITS, number_field
from .push_size import MAX_PLACE_SIGMA_M
from .settings_table import SettingsTable, choice, in_si_units

# Beyond these a number is a slip of units, not a reading: the joints end before 60 degrees, the
# snake tumbles before 45, and no treadmill runs faster than 10 m/s.
MAX_LAMBDA_DEG, MAX_INCLINE_DEG, MAX_SPEED_M_S = 60.0, 45.0, 10.0
MAX_ANGLE_SIGMA_DEG = math.degrees(0.2)  # beyond it no linear law of small angles holds


@dataclass(frozen=True, kw_only=True)
class Instruments(SettingsTable):
    """The table [instruments]: standard deviations, 0 for what is exact, and steps.

    incline_sigma_deg: of one reading of the inclinometer; incline_zero_sigma_deg: of its zero.
    belt_speed_sigma_m_s: of one belt speed past the snake. lambda_sigma_deg: of one bend,
    joint_sigma_deg: of each joint about straight. Common to all readings: belt_scale_sigma_percent,
    of the belt's true speed over the one shown, and mass_sigma_percent, of the mass.
    distance_sigma_m, time_sigma_s: of tape and stopwatch. film_scale_sigma_percent: of lengths in
    films. push_time_sigma_s: of a push timed by hand. floor_slope_sigma_deg: of the floor's slope,
    before pushes both ways tell it.
    """

    incline_sigma_deg: float = number_field(
        high=MAX_INCLINE_DEG,
        open_low=True,
        words="inclinometer: smallest step it shows (deg)",
        note="steps of d give d / sqrt(12)",
    )
    incline_zero_sigma_deg: float = number_field(
        high=MAX_INCLINE_DEG,
        note="assumed of phones; a zero measured by reversal takes its place",
    )
    belt_speed_sigma_m_s: float = number_field(high=MAX_SPEED_M_S, open_low=True)
    lambda_sigma_deg: float = number_field(
        high=MAX_LAMBDA_DEG, note="of one bend, protractor and joints"
    )
    belt_scale_sigma_percent: float = number_field(
        high=50.0, default=0.0, note="of the speed that the treadmill shows"
    )
    mass_sigma_percent: float = number_field(high=50.0, default=0.0, note="of the robot's mass")
    joint_sigma_deg: float = number_field(
        high=MAX_ANGLE_SIGMA_DEG,
        default=0.0,
        note="of each joint about straight: 0.5 by servos or straightedge, 1.5 by hand",
    )
    incline_step_percent: float = number_field(
        high=20.0,
        default=0.5,
        open_low=True,
        words="treadmill: smallest step of its incline (% or deg)",
        note="what the treadmill can be set to",
    )
    belt_speed_unit: str = choice(
        *BELT_UNITS, default="m/s", note="that the treadmill shows: of a speed typed without one"
    )
    belt_speed_step_m_s: float = number_field(
        high=MAX_SPEED_M_S,
        default=0.1 / 3.6,
        open_low=True,
        words="belt: smallest step it can be set to",
    )
    belt_speed_least_m_s: float = number_field(
        high=MAX_SPEED_M_S, default=0.0, words="belt: least speed above 0"
    )
    distance_sigma_m: float = number_field(
        high=MAX_PLACE_SIGMA_M, default=0.005, note="of a gait run: tape and marks; stopwatch"
    )
    time_sigma_s: float = number_field(default=0.2)
    film_scale_sigma_percent: float = number_field(
        high=20.0, default=0.5, note="of lengths in a film of pushes"
    )
    push_time_sigma_s: float = number_field(
        high=10.0, default=0.12, open_low=True, note="of a push timed by hand"
    )
    floor_slope_sigma_deg: float = number_field(
        high=MAX_ANGLE_SIGMA_DEG,
        default=0.3,
        open_low=True,
        note="of the floor, before both ways tell it",
    )

    incline_sigma_rad = in_si_units("incline_sigma_deg")
    incline_zero_sigma_rad = in_si_units("incline_zero_sigma_deg")
    lambda_sigma_rad = in_si_units("lambda_sigma_deg")
    belt_scale_sigma = in_si_units("belt_scale_sigma_percent")
    mass_sigma = in_si_units("mass_sigma_percent")
    joint_sigma_rad = in_si_units("joint_sigma_deg")
    incline_step_rad = in_si_units("incline_step_percent")
    film_scale_sigma = in_si_units("film_scale_sigma_percent")
    floor_slope_sigma_rad = in_si_units("floor_slope_sigma_deg")

    def speed(self, distance_m: float, time_s: float) -> tuple[float, float]:
        """Return the mean speed over a distance and its standard deviation, m/s."""
        speed_m_s = distance_m / time_s
        off_m = math.hypot(self.distance_sigma_m, speed_m_s * self.time_sigma_s)
        return speed_m_s, off_m / time_s
