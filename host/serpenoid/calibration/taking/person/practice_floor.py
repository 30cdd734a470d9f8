"""Practice on a floor at a desk: pushes in the lab, filmed into files, by words at the prompt."""

from __future__ import annotations

from pathlib import Path

from ....lab.floor import Track
from ...session import Setup
from ..world import SPEED
from .practice import PracticeTerminal
from .terminal import Terminal

FASTEST_M_S = 2.0
HELP = """\
On the floor you work by words, at any prompt:
  push          push the robot at a brisk walk; a film of it becomes a file, which is taken in
  push 0.6      the same at 0.6 m/s, or so: hands are not exact
  tape          push it, and read way and time to rest off tape and watch, to type them
  protractor    what it shows between the links at both ends
  film          run the gait of this step and film it: what was measured becomes a file, taken in
  crawl         run it for a metre: what tape and watch say"""


class FloorTerminal(PracticeTerminal):
    """A terminal with a floor beside it. Parameters as of a PracticeTerminal."""

    def __init__(self, terminal: Terminal, setup: Setup, seed: int, films: Path):
        words = {
            "push": self._push,
            "tape": self._tape,
            "protractor": self._protractor,
            "floor": lambda given: self.say_aside(HELP),
        }
        super().__init__(terminal, setup, seed, films, words)
        self._end_rad = setup.uncertainty.lambda_sigma_rad

    def _rolled(self, given: str) -> Track | None:
        """Push as told, or say why not."""
        if self.step is None or self.step.kind != "coast":
            self.say_aside(
                "there is nothing to push now: do what the step says first; `floor` lists the words"
            )
            return None
        try:
            speed = float(given or SPEED)
        except ValueError:
            speed = 0.0
        if not 0.05 <= speed <= FASTEST_M_S:
            self.say_aside(f"say how fast in m/s, 0.05 to {FASTEST_M_S:g}: push 0.9")
            return None
        return self.world.push(self.step, speed)

    def _push(self, given: str) -> str | None:
        track = self._rolled(given)
        if track is None:
            return None
        return self.kept("push", ["t", "x", "y"], self.world.film(track))

    def _tape(self, given: str) -> None:
        track = self._rolled(given)
        if track is not None:
            told = (
                "it rolled {distance_m:.3f} m in {duration_s:.2f} s, turned {turned_deg:+.0f} deg"
            )
            self.say_aside(told.format(**self.world.tape(track)))

    def _protractor(self, given: str) -> None:
        tail, head = self.world.ends_deg(self._end_rad)
        self.say_aside(f"protractor: {tail:.1f} deg at the tail, {head:.1f} deg at the head")
