"""Practice on a floor at a desk: pushes in the lab, filmed into files, with a truth by a seed."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ....lab.floor import Track
from ....model.files import write_text
from ....model.gait import Gait
from ....servos.catalogue import servo
from ...session import Session, Setup
from ..steps import Step
from ..world import PHONE, SPEED, FloorWorld, Truth
from .practice import FILM_SCALE, JOINT_RAD, WHEELS_KG, drawn_friction, friction_words
from .push_prompt import CRAWL_COLUMNS, joint_columns
from .terminal import Terminal, WordTerminal

WHEEL_SHAPE, SLOPE_RAD = (0.75, 0.15), math.radians(0.2)
FASTEST_M_S = 2.0
HELP = """\
On the floor you work by words, at any prompt:
  push          push the robot at a brisk walk; a film of it becomes a file, which is taken in
  push 0.6      the same at 0.6 m/s, or so: hands are not exact
  tape          push it, and read way and time to rest off tape and watch, to type them
  protractor    what it shows between the links at both ends
  film          run the gait of this step and film it: what was measured becomes a file, taken in
  crawl         run it for a metre: what tape and watch say"""


def drawn_floor(seed: int) -> Truth:
    """Draw what whoever practises on a floor is to find out; the same seed gives the same."""
    rng = np.random.default_rng([seed, 20])
    ground = drawn_friction(rng)
    slope, scale, shape, across = (float(v) for v in rng.normal(size=4))
    mean, sigma = WHEEL_SHAPE
    return Truth(
        ground,
        joint_sigma_rad=JOINT_RAD,
        rolling_kg=WHEELS_KG * max(mean + sigma * shape, 0.0),
        servo=servo("hobby").draws(1, seed)[0],
        slope_rad=SLOPE_RAD * slope,
        across_rad=SLOPE_RAD * across,
        film_scale=1.0 + FILM_SCALE * scale,
    )


def floor_words(truth: Truth) -> str:
    """Return a floor's truth in a line."""
    return (
        f"{friction_words(truth.ground)}; the floor falls by "
        f"{math.degrees(truth.slope_rad):+.2f} deg towards there and "
        f"{math.degrees(truth.across_rad):+.2f} deg to the left of it"
    )


class FloorTerminal(WordTerminal):
    """A terminal with a floor beside it.

    films: folder that films are put into, as CSV. watch: is to be told of every step.
    """

    def __init__(self, terminal: Terminal, setup: Setup, seed: int, films: Path):
        words: dict[str, Callable[[str], str | None]] = {
            "push": self._push,
            "tape": self._tape,
            "protractor": self._protractor,
            "crawl": self._crawl,
            "film": self._film,
            "floor": lambda given: self.say_aside(HELP),
        }
        super().__init__(terminal, words)
        self._setup, self._films = setup, films
        there = len(list(films.glob("*.csv"))) if films.is_dir() else 0
        rngs = (np.random.default_rng(seeds) for seeds in ([seed, 21, there], [seed, 22]))
        self.world = FloorWorld(setup, drawn_floor(seed), *rngs)
        self._step: Step | None = None
        self._count = there

    def watch(self, session: Session, step: Step) -> None:
        """Note the step that the dialogue is at."""
        self._step = step
        self.world.bend(step.lambda_deg)

    def _rolled(self, given: str) -> Track | None:
        """Push as told, or say why not."""
        if self._step is None or self._step.kind != "coast":
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
        return self.world.push(self._step, speed)

    def _push(self, given: str) -> str | None:
        track = self._rolled(given)
        if track is None:
            return None
        return self._kept("push", ["t", "x", "y"], self.world.film(track, PHONE))

    def _kept(self, what: str, columns: list[str], rows: NDArray[np.float64]) -> str:
        """Write what a film showed into a file of its own; return its name."""
        self._count += 1
        self._films.mkdir(parents=True, exist_ok=True)
        path = self._films / f"{what}-{self._count:02}.csv"
        lines = [",".join(f"{value:.6f}" for value in row) for row in rows.tolist()]
        write_text(path, "\n".join([",".join(columns), *lines]) + "\n")
        self.say_aside(f"filmed, and tracked: {path}")
        return str(path)

    def _tape(self, given: str) -> None:
        track = self._rolled(given)
        if track is not None:
            read = (
                "it rolled {distance_m:.3f} m in {duration_s:.2f} s, turned {turned_deg:+.0f} deg"
            )
            self.say_aside(read.format(**self.world.tape(track)))

    def _protractor(self, given: str) -> None:
        ends_rad = self.world.ends_rad(self._setup.uncertainty.lambda_sigma_rad)
        tail, head = (180.0 - math.degrees(end_rad) for end_rad in ends_rad)
        self.say_aside(f"protractor: {tail:.1f} deg at the tail, {head:.1f} deg at the head")

    def _gait(self) -> tuple[Step, Gait] | None:
        """Return the step and its gait, or say that there is none."""
        if self._step is None or self._step.gait is None:
            return self.say_aside("no gait is to be run at this step; `floor` lists the words")
        return self._step, self._step.gait

    def _film(self, given: str) -> str | None:
        run = self._gait()
        if run is None:
            return None
        rows = self.world.film_crawl(*run, PHONE)
        return self._kept("crawl", [*CRAWL_COLUMNS, *joint_columns(rows.shape[1] - 4)], rows)

    def _crawl(self, given: str) -> None:
        run = self._gait()
        if run is not None:
            read, _ = self.world.time_crawl(*run)
            self.say_aside("it crawled {distance_m:.3f} m in {duration_s:.2f} s".format(**read))
