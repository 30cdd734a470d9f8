"""A treadmill to practise at: it runs by the clock, and whoever practises sets and reads it."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np

from ..model.errors import BadInput
from .belt import Belt
from .instruments import FILM_S, RULER_M, Instrument
from .person import Display
from .robot import LabRobot

TICK_S = 0.04
MOST_BEHIND_S = 1.0  # to catch up with after the computer slept
MOST_GRADE_STEPS = 30  # 15 % in steps of 0.5 %
MOST_BELT_M_S = 4.0
LET_GO_M_S, LET_GO_RAD, LET_GO_RAD_S = 0.02, math.radians(1.5), math.radians(2.0)
DISPLAY, INCLINOMETER_RAD = Display(), Instrument(step=math.radians(0.1))
SetPoints = Callable[[], Sequence[float]]
BELT_LENGTH_M = 2.8
STEPS = {"+": 1, "-": -1}
# What the page calls some words with what is given to them.
BUTTONS = {
    "faster": ("belt", "+"),
    "slower": ("belt", "-"),
    "steeper": ("incline", "+"),
    "flatter": ("incline", "-"),
    "put_up": ("put", "up"),
}


def amount(text: str, says: str, *units: str, low: float = -1e9, high: float = 1e9) -> float:
    """Return a number that was typed with or without a unit; raises BadInput with what to say."""
    for unit in units:
        text = text.removesuffix(unit).strip()
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not low <= value <= high:
        raise BadInput(says)
    return value


def protractor_in_words(shown_deg: Sequence[float]) -> str:
    """Return what a protractor shows between the links at tail and head."""
    return "protractor: {:.1f} deg at the tail, {:.1f} deg at the head".format(*shown_deg)


class PracticeTreadmill:
    """A robot on a treadmill that runs by the clock from start() to stop().

    set_points: where the robot's joints are told to stand now, rad, such as a virtual board's.
    inclinometer_rad: with the zero that is to be found. grade_step: of the treadmill's incline, as
    a tangent. deck_rad: how the deck lies where the treadmill says 0. pace: how many seconds pass
    in one of the clock. lies: the robot is on the belt, else in somebody's hand. words: what may be
    typed there, with what is given to them; each returns what to show, or raises BadInput. buttons:
    of the page, by their names.
    """

    def __init__(
        self,
        robot: LabRobot,
        set_points: SetPoints,
        display: Display = DISPLAY,
        inclinometer_rad: Instrument = INCLINOMETER_RAD,
        *,
        grade_step: float = 0.005,
        deck_rad: float = 0.0,
        protractor_rad: float = 0.007,
        seed: int = 0,
        pace: float = 1.0,
    ):
        self.belt = Belt(robot)
        self._set_points, self.display = set_points, display
        self._inclinometer_rad, self._protractor_rad = inclinometer_rad, protractor_rad
        self.grade_step, self._deck_rad, self._pace = grade_step, deck_rad, pace
        self._rng = np.random.default_rng(seed)
        self._grade = self._shown_steps = 0
        self.lies = False
        self._mark: tuple[float, float] | None = None
        self._lock = threading.RLock()
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._go_on, daemon=True)
        self.belt.tilt(deck_rad)
        self.words: dict[str, Callable[[str], str]] = {
            "belt": self._belt_word,
            "incline": self._incline_word,
            "put": self.put,
            "take": self.take,
            "mark": self.mark,
            "inclinometer": self.inclinometer,
            "turned": lambda given: self.inclinometer(turned=True),
            "protractor": self.protractor,
            "turns": self.turns,
        }
        self.buttons = {word: partial(obey, "") for word, obey in self.words.items()} | {
            name: partial(self.words[word], given) for name, (word, given) in BUTTONS.items()
        }

    def start(self) -> PracticeTreadmill:
        """Let time pass from now on."""
        self._thread.start()
        return self

    def stop(self) -> None:
        """Let no more time pass."""
        self._ended.set()
        self._thread.join()

    def _go_on(self) -> None:
        last = time.monotonic()
        while not self._ended.wait(TICK_S):
            now = time.monotonic()
            self.pass_time(min((now - last) * self._pace, MOST_BEHIND_S * self._pace))
            last = now

    def pass_time(self, duration_s: float) -> None:
        """Let the world's time pass, the joints going where they are told."""
        with self._lock:
            set_rad = self._set_points()
            if not self.lies:
                self.belt.pose(set_rad)
                self.belt.t_s += duration_s
                return
            self.belt.lead(set_rad)
            self.belt.wait(max(duration_s, 1e-4))
            if self.belt.off:
                self.lies = False

    @property
    def belt_shown_m_s(self) -> float:
        """Return what the treadmill shows."""
        return self._shown_steps * self.display.step_m_s

    def _belt_word(self, given: str) -> str:
        if given in STEPS:
            return self.set_belt(self._shown_steps + STEPS[given])
        says = "say how fast in km/h: belt 1.6; or belt +, belt -"
        shown = amount(given, says, "km/h", "kmh")
        return self.set_belt(round(shown / 3.6 / self.display.step_m_s))

    def _incline_word(self, given: str) -> str:
        if given in STEPS:
            return self.set_grade(self._grade + STEPS[given])
        says = "say how steep in %: incline 4; or incline +, incline -"
        return self.set_grade(round(amount(given, says, "%") / 100 / self.grade_step))

    def set_belt(self, steps: int) -> str:
        """Set the belt, in steps of its display; return what it shows."""
        with self._lock:
            least = math.ceil(self.display.least_m_s / self.display.step_m_s - 1e-9)
            most = int(MOST_BELT_M_S / self.display.step_m_s)
            before, steps = self._shown_steps, min(max(steps, 0), most)
            if 0 < steps < least:
                steps = least if steps > before else 0
            self._shown_steps = steps
            off = self.display.scatter_m_s * float(self._rng.normal()) if steps else 0.0
            self.belt.run(max(self.belt_shown_m_s * self.display.scale + off, 0.0))
            return self.belt_in_words()

    def belt_in_words(self) -> str:
        """Return what the belt's display shows."""
        return f"belt {3.6 * self.belt_shown_m_s:.1f} km/h ({self.belt_shown_m_s:.3f} m/s)"

    def set_grade(self, steps: int) -> str:
        """Raise or lower the treadmill, in its own steps; return what it shows."""
        with self._lock:
            self._grade = min(max(steps, 0), MOST_GRADE_STEPS)
            self.belt.tilt(self._incline_rad)
            return f"incline {100 * self._grade * self.grade_step:.1f} % by the treadmill"

    @property
    def _incline_rad(self) -> float:
        return math.atan(self._grade * self.grade_step) + self._deck_rad

    def put(self, given: str = "") -> str:
        """Lay the robot in the middle of the belt and let go of it; given: "up", head uphill."""
        facing = "up" if given == "up" else "down"
        with self._lock:
            normal = self._rng.normal(size=4)
            self.lies, self._mark = True, None
            self.belt.put(
                0.01 * normal[0],
                LET_GO_RAD * normal[1],
                facing,
                LET_GO_M_S * normal[2],
                LET_GO_RAD_S * normal[3],
            )
            return f"the robot is on the belt, head {facing}hill"

    def take(self, given: str = "") -> str:
        """Take the robot off the belt."""
        with self._lock:
            self.lies = False
            return "the robot is in your hand"

    def mark(self, given: str = "") -> str:
        """Mark where the robot is and start the watch; the second time, read both."""
        with self._lock:
            if not self.lies:
                self._mark = None
                return "the robot is not on the belt"
            sight = self.belt.look()
            if self._mark is None:
                self._mark = sight.t_s, RULER_M.shows(sight.along_m, self._rng)
                return "marked; the watch runs: press again to read"
            since, begun = sight.t_s - self._mark[0], self._mark[1]
            uphill = begun - RULER_M.shows(sight.along_m, self._rng)
            self._mark = None
            drift = uphill / since if since > 0.2 else 0.0
            return f"{1000 * uphill:+.0f} mm uphill in {since:.1f} s: drift {drift:+.3f} m/s"

    def place(self) -> tuple[float, float]:
        """Return the time, s, and where a film shows the robot against a ruler, m uphill."""
        with self._lock:
            sight = self.belt.look()
            return FILM_S.shows(sight.t_s, self._rng), -RULER_M.shows(sight.along_m, self._rng)

    def inclinometer(self, given: str = "", *, turned: bool = False) -> str:
        """Return what the inclinometer on the deck shows, or shows turned end for end."""
        incline = -self._incline_rad if turned else self._incline_rad
        shown = math.degrees(self._inclinometer_rad.shows(incline, self._rng))
        return f"inclinometer{', turned,' if turned else ''} {shown:.1f} deg"

    def protractor(self, given: str = "") -> str:
        """Return what a protractor shows between the links at either end."""
        with self._lock:
            return protractor_in_words(
                self.belt.robot.protractor_deg(self._set_points(), self._protractor_rad, self._rng)
            )

    def turns(self, given: str = "") -> str:
        """Time ten turns of a mark on the belt, with a hand's error."""
        with self._lock:
            shown_m_s = self.belt_shown_m_s
            if not shown_m_s:
                return "the belt stands"
            way_m = 10 * BELT_LENGTH_M
            duration_s = way_m / (shown_m_s * self.display.scale) + 0.2 * float(self._rng.normal())
            return f"ten turns of {BELT_LENGTH_M:g} m, {way_m:g} m, in {duration_s:.1f} s"

    def look(self) -> str:
        """Return what anybody sees, in a line."""
        return f"{self._where()}; {self.belt_in_words()}"

    def _where(self) -> str:
        with self._lock:
            if not self.lies:
                return "the robot is off the belt"
            sight = self.belt.look()
            downhill_m, left_m = sight.along_m, sight.across_m
            return (
                f"{1000 * abs(downhill_m):.0f} mm {'down' if downhill_m > 0 else 'up'}hill of the "
                f"middle, {1000 * abs(left_m):.0f} mm {'left' if left_m > 0 else 'right'}"
                f" of it, turned {math.degrees(sight.heading_rad):+.0f} deg"
            )

    def state(self) -> dict[str, Any]:
        """Return what the page draws: links' ends in m, x downhill, and what the displays show."""
        with self._lock:
            half = self.belt.robot.body.link_length_m / 2
            places = self.belt.places()
            x, y, angle = places.T
            c, s = half * np.cos(angle), half * np.sin(angle)
            ends = np.stack([np.append(x - c, x[-1] + c[-1]), np.append(y - s, y[-1] + s[-1])])
            grade = 100 * self._grade * self.grade_step
            return {
                "chain": np.round(ends.T, 4).tolist(),
                "lies": self.lies,
                "moved_m": round(self.belt.moved_m, 4),
                "belt": self.belt_in_words(),
                "incline": f"{grade:.1f} %",
                "tilt_deg": round(math.degrees(self._incline_rad), 2),
                "watch_s": None if self._mark is None else round(self.belt.t_s - self._mark[0], 1),
                "look": self._where(),
            }
