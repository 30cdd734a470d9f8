"""Practice at a desk: a treadmill of the lab, worked by words at the prompt."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from ....lab.practice import PracticeTreadmill, SetPoints
from ...kinds.places import MOST_S
from ...session import Setup
from .practice import PracticeTerminal
from .terminal import Terminal

LONGEST_WAIT_S = 600.0
HELP = """\
The treadmill is worked by words, or on its page:
  belt 1.6      belt speed in km/h; belt +, belt - by a step
  incline 4     in %; incline +, incline - by a step
  put           lay the robot on the belt and let go (put up: head uphill); take: off again
  left, right   steer by a step (left 4: four steps)
  look          where the robot is, as a picture
  mark          ruler and watch; again: how far and how long, and so the drift
  film 4        4 s of film: places to type for the drift, where it cannot be held
  inclinometer  what it shows; turned: laid the other way round
  protractor    what it shows between the links at both ends
  turns         mark the belt and time ten turns
  film, crawl   at a gait run: run it on level ground; a film is taken in, or what a watch says
  wait 20       let 20 s pass"""


class TreadmillTerminal(PracticeTerminal):
    """A terminal that works a treadmill, too, its robot's joints where a board has set them.

    room: the treadmill. Other parameters as of a PracticeTerminal and of a PracticeTreadmill.
    """

    def __init__(
        self,
        terminal: Terminal,
        setup: Setup,
        seed: int,
        films: Path,
        set_points: SetPoints,
        pace: float = 1.0,
    ):
        buttons = "take", "mark", "inclinometer", "turned", "protractor", "turns"
        told: dict[str, Callable[[str], str]] = {
            "belt": self._belt,
            "incline": self._incline,
            "wait": self._wait,
            "left": self._steer("left"),
            "right": self._steer("right"),
            "put": lambda given: self.room.put("up" if given == "up" else "down"),
            "look": lambda given: f"{picture(self.room)}\n  {self.room.look()}",
            "treadmill": lambda given: HELP,
            **{name: self._button(name) for name in buttons},
        }
        words = {name: self._telling(word) for name, word in told.items()}
        super().__init__(terminal, setup, seed, films, words)
        truth = self.world.truth
        self._pace = pace
        self.room = PracticeTreadmill(
            self.world.robot,
            set_points,
            truth.display(setup, scatter=0.5),
            truth.inclinometer_rad(setup),
            grade_step=setup.treadmill.incline_step_rad,
            deck_rad=truth.deck_rad,
            protractor_rad=setup.uncertainty.lambda_sigma_rad,
            seed=seed,
            pace=pace,
        )

    def _telling(self, word: Callable[[str], str]) -> Callable[[str], None]:
        return lambda given: self.say_aside(word(given))

    def clock_s(self) -> float:
        """Return the time at the treadmill, s, whatever its pace."""
        return self.room.belt.t_s

    def _button(self, name: str) -> Callable[[str], str]:
        return lambda given: self.room.buttons[name]()

    def _belt(self, given: str) -> str:
        room = self.room
        if given in ("+", "-"):
            return room.buttons["faster" if given == "+" else "slower"]()
        shown = _number(given, ("km/h", "kmh"))
        if shown is None:
            return "say how fast in km/h: belt 1.6; or belt +, belt -"
        return room.set_belt(round(shown / 3.6 / room.display.step_m_s))

    def _incline(self, given: str) -> str:
        room = self.room
        if given in ("+", "-"):
            return room.buttons["steeper" if given == "+" else "flatter"]()
        shown = _number(given, ("%",))
        if shown is None:
            return "say how steep in %: incline 4; or incline +, incline -"
        return room.set_grade(round(shown / 100 / room.grade_step))

    def _wait(self, given: str) -> str:
        seconds = _number(given, ("s",))
        if seconds is None or not 0 < seconds <= LONGEST_WAIT_S:
            return f"say how long in s, at most {LONGEST_WAIT_S:g}: wait 20"
        time.sleep(seconds / self._pace)
        return self.room.look()

    def _film(self, given: str) -> str | None:
        """Film a gait, where one is to be run; else where the robot on the belt is."""
        if self.step is not None and self.step.gait is not None:
            return super()._film(given)
        return self.say_aside(self._places(given))

    def _places(self, given: str) -> str:
        seconds = _number(given or "4", ("s",))
        if seconds is None or not 2 <= seconds <= MOST_S:
            return f"say how long in s, 2 to {MOST_S:g}: film 4"
        room, found = self.room, list[tuple[float, float]]()
        while room.lies and (not found or found[-1][0] - found[0][0] < seconds - 0.1):
            time.sleep((1.0 if found else 0.0) / self._pace)
            found.append(room.place())
        if len(found) < 3:
            return "the robot is not on the belt"
        places = " ".join(f"{t - found[0][0]:.2f}:{y:.3f}" for t, y in found)
        return f"places, s:m uphill, to type for the drift: {places}"

    def _steer(self, way: str) -> Callable[[str], str]:
        def steer(given: str) -> str:
            steps = _number(given or "1", ())
            if way not in self.keys or steps is None or not 0 < steps <= 40:
                return "no robot to steer, or no number of steps from 1 to 40"
            return [self.keys[way]() for _ in range(int(steps))][-1]

        return steer


def _number(text: str, units: tuple[str, ...]) -> float | None:
    for unit in units:
        text = text.removesuffix(unit).strip()
    try:
        value = float(text)
    except ValueError:
        return None
    return value if math.isfinite(value) else None


def picture(treadmill: PracticeTreadmill) -> str:
    """Return the robot on the belt from above in characters, downhill to the right."""
    state, columns, rows = treadmill.state(), 61, 9
    grid = [["."] * columns for _ in range(rows)]
    grid[rows // 2][columns // 2] = "+"
    if state["lies"]:
        ends = np.array(state["chain"])
        for t in np.linspace(0.0, len(ends) - 1.0, 200):
            x, y = (float(np.interp(t, np.arange(len(ends)), way)) for way in ends.T)
            column = round((columns - 1) * (x + 0.62) / 1.24)
            row = round((rows - 1) * (0.22 - y) / 0.44)
            if 0 <= column < columns and 0 <= row < rows:
                grid[row][column] = "O" if t > len(ends) - 1.4 else "#"
    lines = ["".join(row) for row in grid]
    return "\n  ".join(["uphill, the belt runs here <<" + " " * 20 + "downhill", *lines])
