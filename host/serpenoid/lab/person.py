"""A person at the treadmill: steers, sets the belt until the robot holds, waits, and reads.

Knows what anybody there sees: where the robot is and how it lies, what the displays show, and that
one degree on every joint turns a robot by its speed over the length of a link. Knows no friction.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from .belt import Belt, Sight
from .instruments import CLOCK_S, EYE_M, EYE_RAD, RULER_M

LOOK_S = 0.5  # Time between looks.
# Speed below which a robot goes by jerks: every touch of the steering shakes wheels loose that
# would rest, and it creeps where it should stand. No reading is taken there.
CREEP_M_S = 0.12


@dataclass(frozen=True)
class Station:
    """A station as it was read: belt_shown_m_s, and drift_m_s, positive uphill with the belt.

    turned_rad: heading at the end of the watch, by eye. offset_rad: the steering then.
    """

    belt_shown_m_s: float
    drift_m_s: float
    turned_rad: float
    offset_rad: float


@dataclass(frozen=True)
class Display:
    """The treadmill's own display: its steps, the truth over what it shows, and its least speed.

    scatter_m_s: by which the belt runs faster or slower than shown, another each time it is set.
    """

    step_m_s: float = 0.1 / 3.6
    scale: float = 1.0
    least_m_s: float = 0.0
    scatter_m_s: float = 0.0

    def nearest(self, wanted_m_s: float) -> float:
        """Return the shown speed nearest to one that is wanted."""
        steps = max(round(wanted_m_s / self.step_m_s), 1)
        return max(steps * self.step_m_s, self.least_m_s)


def limited(value: float, limit: float) -> float:
    """Return a value, at most as large as a limit either way."""
    return min(max(value, -limit), limit)


class Person:
    """Work at a belt; the same seed does the same.

    The robot is steered in steps, by what is seen each half second. trim_rad: the offset that runs
    straight, which is kept. offset_rad: the steering now.
    """

    def __init__(self, belt: Belt, rng: np.random.Generator, display: Display = Display()):
        self.belt, self.rng, self.display = belt, rng, display
        self.trim_rad, self.offset_rad = 0.0, 0.0

    def hold(self, guess_m_s: float, settle_s: float) -> Station | None:
        """Set the belt until the robot keeps its place, wait, read; None where it cannot be held.

        guess_m_s: where to begin, as the belt shows it.
        """
        step_m_s, shown_m_s = self.display.step_m_s, self.display.nearest(guess_m_s)
        stride_m_s, last_direction = 4 * step_m_s, 0
        for _ in range(25):  # until somebody gives up
            station, drift_m_s = self._try(shown_m_s, settle_s)
            if station is not None and abs(drift_m_s) <= 0.7 * step_m_s:
                if not self._rolls(station, CREEP_M_S):
                    return None
                if self._rolls(station, 1.5 * CREEP_M_S):
                    return station
                # Of readings that are kept only if they are fast enough, the mean would be too
                # fast: the belt is set once more, and what is read then is taken.
                station, _ = self._try(shown_m_s, settle_s)
                return station if station is not None and self._rolls(station, 0.0) else None
            direction = 1 if drift_m_s < 0 else -1  # robot runs ahead: the belt is too slow
            change_m_s = max(abs(drift_m_s), step_m_s)
            if station is None:  # it left the belt: nobody saw where it would settle
                stride_m_s = stride_m_s / 2 if last_direction == -direction else stride_m_s
                change_m_s, last_direction = max(change_m_s, stride_m_s), direction
            nearest_m_s = self.display.nearest(shown_m_s + direction * change_m_s)
            if nearest_m_s == shown_m_s and direction < 0:
                return None
            shown_m_s = nearest_m_s
        return None

    def _rolls(self, station: Station, slip_m_s: float) -> bool:
        """Tell whether wheels roll that fast at least, and the belt does not carry the robot.

        One that drifts by a quarter of the belt's speed is carried off: its wheels hardly roll.
        """
        shown_m_s, drift_m_s = station.belt_shown_m_s, station.drift_m_s
        return drift_m_s <= 0.25 * shown_m_s and shown_m_s - drift_m_s > slip_m_s

    def _try(self, shown_m_s: float, settle_s: float) -> tuple[Station | None, float]:
        """Let the robot go on the running belt; return what was read, and the drift seen last."""
        error_m_s = self.display.scatter_m_s * float(self.rng.normal())
        self.belt.run(max(shown_m_s * self.display.scale + error_m_s, 0.0))
        # Scatter: across, m; heading, rad; speed, m/s; turning, rad/s.
        scatter = np.array([0.01, math.radians(2.0), 0.03, math.radians(3.0)])
        self.belt.put(*(scatter * self.rng.normal(size=4)).tolist())
        self.belt.steer(self.trim_rad)
        looks = self._watch(shown_m_s, settle_s)
        if self._leaves(looks[-1]):
            return None, self._drift(looks[-4:])
        looks = looks[-8:]
        drift_m_s = self._drift(looks)
        if abs(drift_m_s) <= 1.2 * self.display.step_m_s:  # else it is no use to watch it longer
            looks, fewest_looks = self._watch(shown_m_s, 6.0), 5
            drift_m_s = self._drift(looks)
            if len(looks) < fewest_looks:
                return None, drift_m_s
        turned_rad = EYE_RAD.shows(looks[-1].heading_rad, self.rng)
        return Station(shown_m_s, drift_m_s, turned_rad, self.offset_rad), drift_m_s

    def _watch(self, shown_m_s: float, duration_s: float) -> list[Sight]:
        """Steer and look until the time is over or the robot leaves; return what was there."""
        looks = [self.belt.look()]
        for _ in range(max(1, round(duration_s / LOOK_S))):
            self._steer(looks[-1], shown_m_s)
            self.belt.wait(LOOK_S)
            looks.append(self.belt.look())
            if self._leaves(looks[-1]):
                break
        return looks

    def _steer(self, look: Sight, speed_m_s: float) -> None:
        """Set the offset for the next half second."""
        across_m = EYE_M.shows(look.across_m, self.rng)
        # The robot is aimed at the middle by a radian to a metre.
        error_rad = limited(-across_m, 0.2) - EYE_RAD.shows(look.heading_rad, self.rng)
        # rad of offset for a rad a second
        turn = self.belt.robot.body.link_length_m / max(speed_m_s, 0.2)
        trim_rad = self.trim_rad + 0.2 * turn * error_rad * LOOK_S
        self.trim_rad = limited(trim_rad, math.radians(2.5))
        offset = limited(0.5 * turn * error_rad / LOOK_S + self.trim_rad, math.radians(3.0))
        step_rad = math.radians(0.25)
        self.offset_rad = round(offset / step_rad) * step_rad
        self.belt.steer(self.offset_rad)

    def _leaves(self, look: Sight) -> bool:
        """Tell whether the robot left the belt, or is so near its end that it is taken back."""
        half_length_m, half_width_m = 0.45, 0.22
        return abs(look.along_m) > half_length_m or abs(look.across_m) > half_width_m

    def _drift(self, looks: list[Sight]) -> float:
        """Return the drift, m/s, uphill, by ruler and clock between the ends of a watch."""
        first, last = looks[0], looks[-1]
        way_m = RULER_M.shows(last.along_m, self.rng) - RULER_M.shows(first.along_m, self.rng)
        return -way_m / max(CLOCK_S.shows(last.t_s - first.t_s, self.rng), 0.1)
