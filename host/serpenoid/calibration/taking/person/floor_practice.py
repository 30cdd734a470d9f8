"""Practice on a floor at a desk: pushes in the lab, filmed into files, with a truth by a seed."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ....lab.crawl import crawl_speed, filmed_crawl
from ....lab.floor import Floor, Push, Track
from ....lab.recording import Camera, film, to_rest
from ....lab.robot import LabRobot, pose_of
from ....model.bends import balanced_signs
from ....model.files import write_text
from ....model.ground import Ground
from ....servos.catalogue import servo
from ...session import Session, Setup
from ..floor.simulated import CROOKED_RAD, SPEED, SPIN_RAD_S, crawled_slopes
from ..simulated import timed_crawl
from ..steps import Step
from .practice import FILM_SCALE, JOINT_RAD, WHEELS_KG, drawn_friction, friction_words
from .push_prompt import CRAWL_COLUMNS, joint_columns
from .terminal import Terminal

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


@dataclass(frozen=True)
class PracticeFloorTruth:
    """What whoever practises is to find out: friction, the floor's slopes, the wheels' J / r^2."""

    ground: Ground
    slope_rad: float
    across_rad: float
    film_scale: float
    rolling_kg: float

    @classmethod
    def drawn(cls, seed: int) -> PracticeFloorTruth:
        """Draw one; the same seed gives the same."""
        rng = np.random.default_rng([seed, 20])
        ground = drawn_friction(rng)
        slope, scale, shape, across = (float(v) for v in rng.normal(size=4))
        mean, sigma = WHEEL_SHAPE
        return cls(
            ground,
            SLOPE_RAD * slope,
            SLOPE_RAD * across,
            1.0 + FILM_SCALE * scale,
            WHEELS_KG * max(mean + sigma * shape, 0.0),
        )

    def in_words(self) -> str:
        """Return it in a line."""
        return (
            f"{friction_words(self.ground)}; the floor falls by "
            f"{math.degrees(self.slope_rad):+.2f} deg towards there and "
            f"{math.degrees(self.across_rad):+.2f} deg to the left of it"
        )


class FloorTerminal:
    """A terminal with a floor beside it: what is no word of it goes to the dialogue.

    films: folder that films are put into, as CSV. watch: is to be told of every step.
    """

    def __init__(self, terminal: Terminal, setup: Setup, seed: int, films: Path):
        self._terminal, self._setup, self._films = terminal, setup, films
        self.keys: Mapping[str, Callable[[], str]] = {}
        truth = self.truth = PracticeFloorTruth.drawn(seed)
        there = len(list(films.glob("*.csv"))) if films.is_dir() else 0
        self._rng = np.random.default_rng([seed, 21, there])
        hidden = servo("hobby").draws(1, seed)[0]
        whole = LabRobot.whole(setup.robot, truth.ground, rolling_kg=truth.rolling_kg, servo=hidden)
        self._robot = whole.drawn(np.random.default_rng([seed, 22]), JOINT_RAD)
        self._floor = Floor(self._robot, truth.slope_rad, 0.0, truth.across_rad)
        self._step: Step | None = None
        self._count = there
        self._words: dict[str, Callable[[str], str | None]] = {
            "push": self._push,
            "tape": self._tape,
            "protractor": self._protractor,
            "crawl": self._crawl,
            "film": self._film,
            "floor": lambda given: self._said(HELP),
        }

    def watch(self, session: Session, step: Step) -> None:
        """Note the step that the dialogue is at."""
        self._step = step

    def say(self, text: str) -> None:
        """Show a line or more."""
        self._terminal.say(text)

    def forget(self) -> None:
        """Drop what was typed ahead."""
        self._terminal.forget()

    def ask(self, prompt: str, patience_s: float, tick: Callable[[], None]) -> str | None:
        """Return the next line that is not for the floor; a film's name in place of `push`."""
        while True:
            line = self._terminal.ask(prompt, patience_s, tick)
            word, _, given = (line or "").strip().lower().partition(" ")
            if line is None or word not in self._words:
                return line
            answer = self._words[word](given.strip())
            if answer is not None:
                return answer

    def _said(self, text: str) -> None:
        self.say("  " + text)

    def _pose(self) -> list[float]:
        bend_deg = self._step.lambda_deg if self._step is not None else 0.0
        return pose_of(balanced_signs(self._setup.robot.links), math.radians(bend_deg))

    def _rolled(self, given: str) -> Track | None:
        """Push as told, or say why not."""
        if self._step is None or self._step.kind != "coast":
            self._said(
                "there is nothing to push now: do what the step says first; `floor` lists the words"
            )
            return None
        try:
            speed = float(given or SPEED)
        except ValueError:
            speed = 0.0
        if not 0.05 <= speed <= FASTEST_M_S:
            self._said(f"say how fast in m/s, 0.05 to {FASTEST_M_S:g}: push 0.9")
            return None
        crooked, spin, off = self._rng.normal(size=3)
        way = 0.0 if self._step.cells["way"] == "there" else math.pi
        push = Push(
            speed * max(1.0 + 0.1 * float(off), 0.3),
            way,
            CROOKED_RAD * float(crooked),
            SPIN_RAD_S * float(spin),
            tail_first=self._step.cells.get("facing") == "back",
        )
        return self._floor.push(self._pose(), push)

    def _push(self, given: str) -> str | None:
        track = self._rolled(given)
        if track is None:
            return None
        seen = film(track, Camera(scale=self.truth.film_scale), self._rng)
        return self._kept("push", ["t", "x", "y"], np.stack([seen.t_s, seen.x_m, seen.y_m], axis=1))

    def _kept(self, what: str, columns: list[str], rows: NDArray[np.float64]) -> str:
        """Write what a film showed into a file of its own; return its name."""
        self._count += 1
        self._films.mkdir(parents=True, exist_ok=True)
        path = self._films / f"{what}-{self._count:02}.csv"
        lines = [",".join(f"{value:.6f}" for value in row) for row in rows.tolist()]
        write_text(path, "\n".join([",".join(columns), *lines]) + "\n")
        self._said(f"filmed, and tracked: {path}")
        return str(path)

    def _tape(self, given: str) -> None:
        track = self._rolled(given)
        if track is not None:
            way_m, time_s = to_rest(track, self._rng)
            turned = math.degrees(track.turned_rad)
            self._said(f"it rolled {way_m:.3f} m in {time_s:.2f} s, turned {turned:+.0f} deg")

    def _protractor(self, given: str) -> None:
        true = self._robot.true_joints(self._pose())
        off = self._setup.uncertainty.lambda_sigma_rad * self._rng.normal(size=2)
        ends = zip((0, -1), off.tolist(), strict=True)
        shown = [180.0 - math.degrees(abs(true[k]) + e) for k, e in ends]
        self._said(f"protractor: {shown[0]:.1f} deg at the tail, {shown[1]:.1f} deg at the head")

    def _film(self, given: str) -> str | None:
        if self._step is None or self._step.gait is None:
            return self._said("no gait is to be run at this step; `floor` lists the words")
        rows = filmed_crawl(
            self._robot,
            self._step.gait,
            Camera(),
            self._rng,
            *crawled_slopes(self._step, self.truth.slope_rad, self.truth.across_rad),
        )
        return self._kept("crawl", [*CRAWL_COLUMNS, *joint_columns(rows.shape[1] - 4)], rows)

    def _crawl(self, given: str) -> None:
        if self._step is None or self._step.gait is None:
            return self._said("no gait is to be run at this step; `floor` lists the words")
        rises, falls = crawled_slopes(self._step, self.truth.slope_rad, self.truth.across_rad)
        speed = crawl_speed(self._robot, self._step.gait, slope_rad=rises, across_rad=falls)
        read, _ = timed_crawl(speed, self._setup.stopwatch, self._rng)
        return self._said("it crawled {distance_m:.3f} m in {duration_s:.2f} s".format(**read))
