"""Practice at a desk: a treadmill of the lab whose truth is drawn by a seed, worked by words."""

from __future__ import annotations

import math
import re
import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ....lab.practice import PracticeTreadmill, SetPoints
from ....model.errors import BadInput
from ....model.ground import Ground
from ...kinds.instruments import FloorTools
from ...kinds.places import MOST_S
from ...session import Session, Setup
from ..new_session import on_place
from ..world import Truth
from .terminal import Terminal, WordTerminal

SOURCE = re.compile(r"practice (treadmill|floor), seed (\d+)")
USUAL = {"ct": 0.084, "cn": 1.2, "ft0": 0.14, "fn0": 0.27}  # the 2005 robot's, whole snake
SPREAD, ZERO_RAD, SCALE, JOINT_RAD = 0.15, math.radians(0.15), 0.02, math.radians(0.5)
WHEELS_KG, FILM_SCALE = 0.036, 0.005  # on a floor
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
  wait 20       let 20 s pass"""


def drawn_friction(rng: np.random.Generator) -> Ground:
    """Draw the whole snake's friction, some way from the 2005 robot's."""
    return Ground(**{k: v * math.exp(SPREAD * rng.normal()) for k, v in USUAL.items()})


def friction_words(g: Ground) -> str:
    """Return the whole snake's friction in a line."""
    return (
        f"the truth, whole snake: ct {g.ct_forward:.4g} N s/m, cn {g.cn:.4g} N s/m, ft0 "
        f"{g.ft0_forward:.4g} N, fn0 {g.fn0:.4g} N"
    )


def drawn_belt(seed: int) -> Truth:
    """Draw what whoever practises at the treadmill is to find out; the same seed gives the same."""
    rng = np.random.default_rng([seed, 2005])
    ground = drawn_friction(rng)
    zero, scale, deck = (float(x) for x in rng.normal(size=3))
    return Truth(
        ground,
        joint_sigma_rad=JOINT_RAD,
        incline_zero_rad=ZERO_RAD * zero,
        belt_scale=1.0 + SCALE * scale,
        deck_rad=math.radians(0.1 * min(max(deck, -2.0), 2.0)),
    )


def belt_words(truth: Truth) -> str:
    """Return a treadmill's truth in a line."""
    return (
        f"{friction_words(truth.ground)}; inclinometer's zero "
        f"{math.degrees(truth.incline_zero_rad):+.2f} deg, belt {truth.belt_scale:.3f} of shown"
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
    found = SOURCE.fullmatch(session.setup.source)
    if found is None or found[1] != place:
        raise BadInput(
            f"{session.folder} is no session of practice on a {place} ({session.setup.source!r}); "
            "give another folder"
        )
    return int(found[2])


def practice_treadmill(
    setup: Setup, seed: int, set_points: SetPoints, pace: float
) -> PracticeTreadmill:
    """Return the treadmill of a session, with the truth of its seed."""
    truth = drawn_belt(seed)
    return PracticeTreadmill(
        truth.robot(setup.robot, np.random.default_rng(seed)),
        set_points,
        truth.display(setup, scatter=0.5),
        truth.inclinometer_rad(setup),
        grade_step=setup.treadmill.incline_step_rad,
        deck_rad=truth.deck_rad,
        protractor_rad=setup.uncertainty.lambda_sigma_rad,
        seed=seed,
        pace=pace,
    )


class PracticeTerminal(WordTerminal):
    """A terminal that works the treadmill, too."""

    def __init__(self, terminal: Terminal, treadmill: PracticeTreadmill, pace: float = 1.0):
        words: dict[str, Callable[[str], str]] = {
            "belt": self._belt,
            "incline": self._incline,
            "wait": self._wait,
            "film": self._film,
            "left": self._steer("left"),
            "right": self._steer("right"),
            "put": lambda given: treadmill.put("up" if given == "up" else "down"),
            "look": lambda given: f"{picture(treadmill)}\n  {treadmill.look()}",
            "treadmill": lambda given: HELP,
            **{
                name: self._button(name)
                for name in ("take", "mark", "inclinometer", "turned", "protractor", "turns")
            },
        }
        super().__init__(terminal, {name: self._telling(word) for name, word in words.items()})
        self._treadmill, self._pace = treadmill, pace

    def _telling(self, word: Callable[[str], str]) -> Callable[[str], None]:
        return lambda given: self.say_aside(word(given))

    def clock_s(self) -> float:
        """Return the time at the treadmill, s, whatever its pace."""
        return self._treadmill.belt.t_s

    def _button(self, name: str) -> Callable[[str], str]:
        return lambda given: self._treadmill.buttons[name]()

    def _belt(self, given: str) -> str:
        room = self._treadmill
        if given in ("+", "-"):
            return room.buttons["faster" if given == "+" else "slower"]()
        shown = _number(given, ("km/h", "kmh"))
        if shown is None:
            return "say how fast in km/h: belt 1.6; or belt +, belt -"
        return room.set_belt(round(shown / 3.6 / room.display.step_m_s))

    def _incline(self, given: str) -> str:
        room = self._treadmill
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
        return self._treadmill.look()

    def _film(self, given: str) -> str:
        seconds = _number(given or "4", ("s",))
        if seconds is None or not 2 <= seconds <= MOST_S:
            return f"say how long in s, 2 to {MOST_S:g}: film 4"
        room, found = self._treadmill, list[tuple[float, float]]()
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
