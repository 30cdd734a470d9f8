"""A person at the treadmill: steers, sets the belt until the robot holds, waits, and reads.

Knows what anybody there sees: where the robot is and how it lies, what the displays show, and that
one degree on every joint turns a robot by its speed over the length of a link. Knows no friction.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

from .belt import HALF_LENGTH_M, Belt, Sight
from .instruments import CLOCK_S, EYE_M, EYE_RAD, FILM_S, RULER_M

LOOK_S, WATCH_S = 0.5, 6.0  # between looks; that a drift is watched
STEER_STEP_RAD = math.radians(0.25)
STEER_MOST_RAD = math.radians(3.0)
TRIM_MOST_RAD = math.radians(2.5)
AIM_MOST_RAD = 0.2
TRIES = 25  # of belt speeds, until somebody gives up
LEAVE_M = 0.75 * HALF_LENGTH_M  # along: time to take the robot back to the middle
CARRIED = 0.25  # of the belt's speed: its wheels hardly roll, the belt carries it off
# Slower than this a robot goes by jerks: every touch of the steering shakes wheels loose that would
# rest, and it creeps where it should stand. No reading is taken there.
CREEP_M_S = 0.12
NEAR = 1.5  # times this, the belt is set once more
PLACE_S, FEWEST_PLACES = 1.0, 3  # of a short reading
DRIFT_M_S = 0.15  # it is gone too soon where it drifts more
TURNED_RAD = math.radians(5.0)  # beyond it a robot is no longer held as the law has it


@dataclass(frozen=True)
class Habits:
    """How a person works.

    hasty: share of stations that are read after a third of the time. let_go_rad, let_go_rad_s,
    let_go_m_s: scatter of heading, turning and speed when the robot is let go.
    """

    hasty: float = 0.0
    let_go_rad: float = math.radians(2.0)
    let_go_rad_s: float = math.radians(3.0)
    let_go_m_s: float = 0.03


@dataclass(frozen=True)
class Held:
    """A station as it was read: belt_shown_m_s, and drift_m_s, positive uphill with the belt.

    turned_rad: heading at the end of the watch, by eye. offset_rad: the steering then. waited_s:
    since the belt was set. places: (t_s, m uphill) of a short reading. seen: (t, along, across,
    heading) at each look of the watch.
    """

    belt_shown_m_s: float
    drift_m_s: float
    turned_rad: float
    offset_rad: float
    waited_s: float
    places: tuple[tuple[float, float], ...] = ()
    seen: tuple[Sight, ...] = field(repr=False, default=())


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
        least = max(self.least_m_s, self.step_m_s)
        return max(round(wanted_m_s / self.step_m_s) * self.step_m_s, least)


class Helm:
    """Steer in steps, by what is seen each half second; the offset that runs straight is kept."""

    def __init__(self, link_m: float):
        self.trim_rad = self.offset_rad = 0.0
        self._link_m = link_m

    def look(self, across_m: float, heading_rad: float, speed_m_s: float) -> float:
        """Return the offset for the next half second, rad."""
        turn = self._link_m / max(speed_m_s, 0.2)  # rad of offset for a rad a second
        aim = min(max(-across_m, -AIM_MOST_RAD), AIM_MOST_RAD)  # a radian to a metre
        off = aim - heading_rad
        trim = self.trim_rad + 0.2 * turn * off * LOOK_S
        self.trim_rad = min(max(trim, -TRIM_MOST_RAD), TRIM_MOST_RAD)
        offset = 0.5 * turn * off / LOOK_S + self.trim_rad
        offset = min(max(offset, -STEER_MOST_RAD), STEER_MOST_RAD)
        self.offset_rad = round(offset / STEER_STEP_RAD) * STEER_STEP_RAD
        return self.offset_rad


class Person:
    """Work at a belt; the same seed does the same."""

    def __init__(
        self,
        belt: Belt,
        rng: np.random.Generator,
        habits: Habits = Habits(),
        display: Display = Display(),
    ):
        self.belt, self.rng, self.habits, self.display = belt, rng, habits, display
        self.helm = Helm(belt.robot.body.link_length_m)

    def hold(self, guess_m_s: float, settle_s: float) -> Held | None:
        """Set the belt until the robot keeps its place, wait, read; None where it cannot be held.

        guess_m_s: where to begin, as the belt shows it.
        """
        shown = self.display.nearest(guess_m_s)
        stride, last = 4 * self.display.step_m_s, 0
        for _ in range(TRIES):
            held, drift_m_s = self._try(shown, self._patience(settle_s))
            step = self.display.step_m_s
            if held is not None and abs(drift_m_s) <= 0.7 * step:
                if not self._rolls(shown, drift_m_s, CREEP_M_S):
                    return None
                return (
                    held if shown - drift_m_s > NEAR * CREEP_M_S else self._again(shown, settle_s)
                )
            downhill = 1 if drift_m_s < 0 else -1  # robot runs ahead: the belt is too slow
            by = abs(drift_m_s)
            if held is None:  # it left the belt: nobody saw where it would settle
                stride = stride / 2 if last == -downhill else stride
                by, last = max(by, stride), downhill
            nearest = self.display.nearest(shown + downhill * max(by, step))
            if nearest == shown and downhill < 0:
                return None
            shown = nearest
        return None

    def film(self, guess_m_s: float, duration_s: float) -> Held | None:
        """Film the robot for some seconds after it was let go; None where it always runs away.

        The belt need not be right: it is set anew only where the robot is carried off quickly.
        """
        shown = self.display.nearest(guess_m_s)
        for _ in range(TRIES):
            held = self._filmed(shown, duration_s)
            if held is not None and abs(held.drift_m_s) < DRIFT_M_S and held.places:
                return held if shown - held.drift_m_s > CREEP_M_S else None
            if held is None:
                return None
            nearest = self.display.nearest(shown - 2 * held.drift_m_s)
            shown = nearest if nearest != shown else shown + self.display.step_m_s
        return None

    def _filmed(self, shown_m_s: float, duration_s: float) -> Held | None:
        """Return a short reading, without places where the robot turned or left too soon.

        The places are read off the film, every PLACE_S or so.
        """
        self._let_go(shown_m_s)
        start_s = self.belt.t_s
        looks = self._watch(shown_m_s, LOOK_S + duration_s)[1:]  # by then the hands are gone
        straight = [abs(at.heading_rad) <= TURNED_RAD for at in looks]
        looks = looks[: straight.index(False)] if False in straight else looks
        if len(looks) < 2:
            return None
        seen, rng = looks[:: round(PLACE_S / LOOK_S)], self.rng
        held = self._held(shown_m_s, looks, self._drift(looks), looks[0].t_s - start_s)
        if len(seen) < FEWEST_PLACES:
            return held
        places = [(FILM_S.shows(at.t_s, rng), -RULER_M.shows(at.along_m, rng)) for at in seen]
        return replace(held, places=tuple((t - places[0][0], y) for t, y in places))

    def _again(self, shown_m_s: float, settle_s: float) -> Held | None:
        """Set the belt once more, and take what is read then: it is not what was judged by.

        Of readings that are kept only if they are fast enough, the mean would be too fast.
        """
        held, drift_m_s = self._try(shown_m_s, self._patience(settle_s))
        return held if held is not None and self._rolls(shown_m_s, drift_m_s, 0.0) else None

    def _rolls(self, shown_m_s: float, drift_m_s: float, least_m_s: float) -> bool:
        return drift_m_s <= CARRIED * shown_m_s and shown_m_s - drift_m_s > least_m_s

    def _try(self, shown_m_s: float, wait_s: float) -> tuple[Held | None, float]:
        """Let the robot go on the running belt; return what was read, and the drift seen last."""
        belt = self.belt
        self._let_go(shown_m_s)
        start_s = belt.t_s
        seen = self._watch(shown_m_s, wait_s)
        if self._leaves(seen[-1]):
            return None, self._drift(seen[-4:])
        recent = self._drift(seen[-8:])
        if abs(recent) > 1.2 * self.display.step_m_s:  # no use to watch this longer
            return self._held(shown_m_s, seen[-8:], recent, belt.t_s - start_s), recent
        waited_s = belt.t_s - start_s
        seen = self._watch(shown_m_s, WATCH_S)
        drift = self._drift(seen)
        if len(seen) < 5:
            return None, drift
        return self._held(shown_m_s, seen, drift, waited_s), drift

    def _let_go(self, shown_m_s: float) -> None:
        """Set the belt, lay the robot on it and let go."""
        belt, rng, habits = self.belt, self.rng, self.habits
        off_m_s = self.display.scatter_m_s * float(rng.normal())
        belt.run(max(shown_m_s * self.display.scale + off_m_s, 0.0))
        belt.put(
            0.01 * float(rng.normal()),
            habits.let_go_rad * float(rng.normal()),
            habits.let_go_m_s * float(rng.normal()),
            habits.let_go_rad_s * float(rng.normal()),
        )
        belt.steer(self.helm.trim_rad)

    def _held(self, shown: float, seen: list[Sight], drift: float, waited_s: float) -> Held:
        turned = EYE_RAD.shows(seen[-1].heading_rad, self.rng)
        return Held(shown, drift, turned, self.helm.offset_rad, waited_s, seen=tuple(seen))

    def _watch(self, shown_m_s: float, duration_s: float) -> list[Sight]:
        """Steer and look until the time is over or the robot leaves; return what was there."""
        seen = [self.belt.look()]
        for _ in range(max(1, round(duration_s / LOOK_S))):
            self._steer(seen[-1], shown_m_s)
            self.belt.wait(LOOK_S)
            seen.append(self.belt.look())
            if self._leaves(seen[-1]):
                break
        return seen

    def _steer(self, at: Sight, shown_m_s: float) -> None:
        across = EYE_M.shows(at.across_m, self.rng)
        heading = EYE_RAD.shows(at.heading_rad, self.rng)
        self.belt.steer(self.helm.look(across, heading, shown_m_s))

    def _leaves(self, at: Sight) -> bool:
        return abs(at.along_m) > LEAVE_M or self.belt.off

    def _drift(self, seen: list[Sight]) -> float:
        """Return the drift, m/s, uphill, by ruler and clock between the ends of what was seen."""
        first, last = seen[0], seen[-1]
        way = RULER_M.shows(last.along_m, self.rng) - RULER_M.shows(first.along_m, self.rng)
        return -way / max(CLOCK_S.shows(last.t_s - first.t_s, self.rng), 0.1)

    def _patience(self, settle_s: float) -> float:
        hasty = float(self.rng.uniform()) < self.habits.hasty
        return settle_s / 3 if hasty else settle_s
