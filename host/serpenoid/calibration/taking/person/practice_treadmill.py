"""Practice at a desk: a treadmill of the lab, worked by words at the prompt."""

from __future__ import annotations

import time
from functools import partial
from pathlib import Path

import numpy as np

from ....lab.practice import PracticeTreadmill, SetPoints, amount
from ....model.errors import BadInput
from ...kinds.places import MOST_S
from ...session import Setup
from .practice import PracticeTerminal
from .terminal import Terminal

LONGEST_WAIT_S = 600.0


class TreadmillTerminal(PracticeTerminal):
    """A terminal that works a treadmill, too, its robot's joints where a board has set them.

    room: the treadmill. Other parameters as of a PracticeTerminal and of a PracticeTreadmill.
    """

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

    def __init__(
        self,
        terminal: Terminal,
        setup: Setup,
        seed: int,
        films: Path,
        set_points: SetPoints,
        pace: float = 1.0,
    ):
        super().__init__(terminal, setup, seed, films)
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
        self.words |= self.room.words | {
            "wait": self._wait,
            "look": lambda given: f"{picture(self.room)}\n  {self.room.look()}",
            "left": partial(self._steer, "left"),
            "right": partial(self._steer, "right"),
        }

    def clock_s(self) -> float:
        """Return the time at the treadmill, s, whatever its pace."""
        return self.room.belt.t_s

    def _wait(self, given: str) -> str:
        says = f"say how long in s, at most {LONGEST_WAIT_S:g}: wait 20"
        time.sleep(amount(given, says, "s", low=1e-9, high=LONGEST_WAIT_S) / self._pace)
        return self.room.look()

    def _film(self, given: str) -> str | Path:
        """Film a gait, where one is to be run; else where the robot on the belt is."""
        if self.step is not None and self.step.gait is not None:
            return super()._film(given)
        says = f"say how long in s, 2 to {MOST_S:g}: film 4"
        seconds = amount(given or "4", says, "s", low=2.0, high=MOST_S)
        room, places = self.room, list[tuple[float, float]]()
        while room.lies and (not places or places[-1][0] - places[0][0] < seconds - 0.1):
            time.sleep((1.0 if places else 0.0) / self._pace)
            places.append(room.place())
        if len(places) < 3:
            raise BadInput("the robot is not on the belt")
        pairs = " ".join(f"{t - places[0][0]:.2f}:{y:.3f}" for t, y in places)
        return f"places, s:m uphill, to type for the drift: {pairs}"

    def _steer(self, way: str, given: str) -> str:
        says = "no robot to steer, or no number of steps from 1 to 40"
        steps = amount(given or "1", says, low=1.0, high=40.0)
        if way not in self.keys:
            raise BadInput(says)
        return [self.keys[way]() for _ in range(int(steps))][-1]


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
