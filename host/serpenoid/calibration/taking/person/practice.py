"""Practice at a desk: what is true there by a seed, and the words that work a floor of the lab."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import ClassVar

import numpy as np

from ....lab.floor import Track
from ....lab.practice import amount, protractor_in_words
from ....model.errors import BadInput
from ....model.files import write_text
from ....model.gait import Gait
from ....model.ground import Ground
from ....servos.catalogue import servo
from ...kinds.instruments import FloorTools
from ...kinds.tracks import Floats
from ...session import Session, Setup
from ..new_session import on_place
from ..steps import Step
from ..world import SPEED, Truth, World
from .push_prompt import CRAWL_COLUMNS, joint_columns
from .terminal import Terminal

SOURCE = re.compile(r"practice (treadmill|floor), seed (\d+)")
USUAL = {"ct": 0.084, "cn": 1.2, "ft0": 0.14, "fn0": 0.27}  # the 2005 robot's, whole snake
SPREAD, ZERO_RAD, SCALE, JOINT_RAD = 0.15, math.radians(0.15), 0.02, math.radians(0.5)
WHEELS_KG, WHEEL_SHAPE = 0.036, (0.75, 0.15)  # on a floor
FILM_SCALE, SLOPE_RAD = 0.005, math.radians(0.2)
SALTS = {"treadmill": 2005, "floor": 20}  # of a place's seeds
SLOWEST_M_S, FASTEST_M_S = 0.05, 2.0  # of a push


def drawn_truth(seed: int, place: str = "treadmill") -> Truth:
    """Draw what whoever practises is to find out; the same seed gives the same."""
    rng = np.random.default_rng([seed, SALTS[place]])
    ground = Ground(**{k: v * math.exp(SPREAD * rng.normal()) for k, v in USUAL.items()})
    truth = Truth(ground, joint_sigma_rad=JOINT_RAD, servo=servo("hobby").draws(1, seed)[0])
    if place == "treadmill":
        zero, scale, deck = (float(x) for x in rng.normal(size=3))
        return replace(
            truth,
            incline_zero_rad=ZERO_RAD * zero,
            belt_scale=1.0 + SCALE * scale,
            deck_rad=math.radians(0.1 * min(max(deck, -2.0), 2.0)),
        )
    slope, scale, shape, across = (float(v) for v in rng.normal(size=4))
    mean, sigma = WHEEL_SHAPE
    return replace(
        truth,
        rolling_kg=WHEELS_KG * max(mean + sigma * shape, 0.0),
        slope_rad=SLOPE_RAD * slope,
        across_rad=SLOPE_RAD * across,
        film_scale=1.0 + FILM_SCALE * scale,
    )


def truth_in_words(truth: Truth, place: str) -> str:
    """Return the truth of a place in a line."""
    g, deg = truth.ground, math.degrees
    where = {
        "treadmill": f"inclinometer's zero {deg(truth.incline_zero_rad):+.2f} deg, belt "
        f"{truth.belt_scale:.3f} of shown",
        "floor": f"the floor falls by {deg(truth.slope_rad):+.2f} deg towards there and "
        f"{deg(truth.across_rad):+.2f} deg to the left of it",
    }
    return (
        f"the truth, whole snake: ct {g.ct_forward:.4g} N s/m, cn {g.cn:.4g} N s/m, ft0 "
        f"{g.ft0_forward:.4g} N, fn0 {g.fn0:.4g} N; {where[place]}"
    )


def practice_setup(setup: Setup, seed: int, place: str = "treadmill") -> Setup:
    """Return a set-up that says that it is practice, where, and of which seed."""
    tools = FloorTools(wheels_kg=WHEELS_KG, film_scale_sigma=FILM_SCALE)
    return replace(
        setup,
        kind="simulated",
        source=f"practice {place}, seed {seed}",
        note="practice: no measurement",
        surface="practice floor" if place == "floor" else "practice belt",
        weighed=True,
        procedure=on_place(setup.procedure, place),
        floor=tools if place == "floor" else setup.floor,
    )


def practice_seed(session: Session, place: str = "treadmill") -> int:
    """Return the seed of a session of practice at a place; raises BadInput for any other."""
    match = SOURCE.fullmatch(session.setup.source)
    if match is None or match[1] != place:
        raise BadInput(
            f"{session.folder} is no session of practice on a {place} ({session.setup.source!r}); "
            "give another folder"
        )
    return int(match[2])


class PracticeTerminal:
    """A terminal with a lab beside it: its words work the lab, and all else is an answer.

    films: folder that films are put into, as CSV. words: what each returns is shown; or answered,
    where it is a film's path. A word that raises BadInput says so. watch: is to be told of every
    step.
    """

    HELP: ClassVar[str]

    def __init__(self, terminal: Terminal, setup: Setup, seed: int, films: Path):
        self._terminal, self._films, self._place = terminal, films, setup.procedure.on
        self._count = len(list(films.glob("*.csv"))) if films.is_dir() else 0
        robot = seed if self._place == "treadmill" else [seed, 22]
        rngs = (np.random.default_rng(key) for key in ([seed, 21, self._count], robot))
        self.world = World(setup, drawn_truth(seed, self._place), *rngs)
        self.step: Step | None = None
        self.keys: Mapping[str, Callable[[], str]] = {}
        self.words: dict[str, Callable[[str], str | Path]] = {
            "crawl": self._crawl,
            "film": self._film,
            self._place: lambda given: self.HELP,
        }

    def say(self, text: str) -> None:
        """Show a line or more."""
        self._terminal.say(text)

    def forget(self) -> None:
        """Drop what was typed ahead."""
        self._terminal.forget()

    def ask(self, prompt: str, patience_s: float, tick: Callable[[], None]) -> str | None:
        """Return the next answer; None if none came in time."""
        if hasattr(self._terminal, "keys"):
            self._terminal.keys = self.keys  # type: ignore[attr-defined]
        while True:
            line = self._terminal.ask(prompt, patience_s, tick)
            word, _, given = (line or "").strip().lower().partition(" ")
            if line is None or word not in self.words:
                return line
            try:
                answer = self.words[word](given.strip())
            except BadInput as error:
                answer = str(error)
            if isinstance(answer, Path):
                return str(answer)
            self.say(f"  {answer}")

    def watch(self, session: Session, step: Step) -> None:
        """Note the step that the dialogue is at."""
        self.step = step
        self.world.bend(step.lambda_deg)

    def kept(self, what: str, columns: list[str], rows: Floats) -> Path:
        """Write what a film showed into a file of its own; return its path."""
        self._count += 1
        self._films.mkdir(parents=True, exist_ok=True)
        path = self._films / f"{what}-{self._count:02}.csv"
        lines = [",".join(f"{value:.6f}" for value in row) for row in rows.tolist()]
        write_text(path, "\n".join([",".join(columns), *lines]) + "\n")
        self.say(f"  filmed, and tracked: {path}")
        return path

    def _run(self) -> tuple[Step, Gait]:
        """Return the step and its gait; raises BadInput where there is none."""
        if self.step is None or self.step.gait is None:
            raise BadInput(f"no gait is to be run at this step; `{self._place}` lists the words")
        return self.step, self.step.gait

    def _film(self, given: str) -> str | Path:
        rows = self.world.film_crawl(*self._run())
        return self.kept("crawl", [*CRAWL_COLUMNS, *joint_columns(rows.shape[1] - 4)], rows)

    def _crawl(self, given: str) -> str:
        read, _ = self.world.time_crawl(*self._run())
        return "it crawled {distance_m:.3f} m in {duration_s:.2f} s".format(**read)


class FloorTerminal(PracticeTerminal):
    """A terminal with a floor beside it: pushes are filmed into files."""

    HELP = """\
On the floor you work by words, at any prompt:
  push          push the robot at a brisk walk; a film of it becomes a file, which is taken in
  push 0.6      the same at 0.6 m/s, or so: hands are not exact
  tape          push it, and read way and time to rest off tape and watch, to type them
  protractor    what it shows between the links at both ends
  film          run the gait of this step and film it: what was measured becomes a file, taken in
  crawl         run it for a metre: what tape and watch say"""

    def __init__(self, terminal: Terminal, setup: Setup, seed: int, films: Path):
        super().__init__(terminal, setup, seed, films)
        self.words |= {
            "push": self._push,
            "tape": self._tape,
            "protractor": lambda given: protractor_in_words(self.world.protractor_deg()),
        }

    def _rolled(self, given: str) -> Track:
        """Push as told; raises BadInput where there is nothing to push."""
        if self.step is None or self.step.kind != "coast":
            raise BadInput(
                "there is nothing to push now: do what the step says first; `floor` lists the words"
            )
        says = f"say how fast in m/s, {SLOWEST_M_S:g} to {FASTEST_M_S:g}: push 0.9"
        speed_m_s = amount(given or str(SPEED), says, low=SLOWEST_M_S, high=FASTEST_M_S)
        return self.world.push(self.step, speed_m_s)

    def _push(self, given: str) -> Path:
        return self.kept("push", ["t", "x", "y"], self.world.film(self._rolled(given)))

    def _tape(self, given: str) -> str:
        words = "it rolled {distance_m:.3f} m in {duration_s:.2f} s, turned {turned_deg:+.0f} deg"
        return words.format(**self.world.tape(self._rolled(given)))
