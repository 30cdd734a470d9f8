"""The person at the treadmill: each step said, each number asked for, each mistake mendable.

At every prompt there are words for undoing, skipping, pausing and leaving. Nothing goes
on by itself; when nobody answers, the robot's servos are let go and that is said.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from ..base.errors import BadInput, CommandRefused, RecordingFailed, RobotError
from ..session.declaration import LENGTH_UNITS, Field, Values
from ..session.journal import Journal
from ..session.places import EXAMPLE, drifts, tidy_places
from ..session.session import Session
from .bends import NEAR_DEG
from .parse_number import span
from .procedure import doubts, likely_belt, next_step
from .prompt import PATIENCE_S, Again, Left, Prompt
from .push_prompt import (
    CRAWL_QUESTION,
    QUESTION,
    FilmReader,
    named_file,
    no_films,
    read_crawl,
    take_track,
)
from .pushes import Kept
from .session_robot import SessionRobot
from .steps import Step, Tracked
from .terminal import Terminal
from .track_files import UnitMissing
from .treadmill import record_step

FILMED = {"push": QUESTION, "gait": CRAWL_QUESTION}  # kinds of steps that a film answers, too
LEFT = "Left. Everything read so far is kept; the same command goes on from here."
Told = Callable[[Session, Step], None]


class Dialogue(Prompt):
    """Take a session step by step with a person.

    robot, patience_s: as of a Prompt. told: called with session and step when a step begins, for
    pictures. clock_s: the time at the treadmill, by which it settles; this machine's
    unless given.
    """

    def __init__(
        self,
        journal: Journal,
        terminal: Terminal,
        robot: SessionRobot | None = None,
        told: Told = lambda session, step: None,
        patience_s: float = PATIENCE_S,
        clock_s: Callable[[], float] | None = None,
        film: FilmReader = no_films,
    ):
        super().__init__(journal, terminal, robot, patience_s)
        self._told, self._film = told, film
        self._clock_s = clock_s or time.monotonic
        if robot is not None:
            robot.offset_rad = steered_rad(journal.session) or 0.0

    def run(self) -> bool:
        """Go on until everything is done or the person leaves; return False if a robot is lost."""
        try:
            self._go_on()
        except RobotError as error:
            self.say(
                f"! the robot: {error}\n  Everything read so far is kept; the same command goes on."
            )
            return False
        return True

    def _go_on(self) -> None:
        self.say("At every prompt: undo, skip, pause, quit, help.")
        if self._robot is not None:
            self.say("Esc or space stops the robot; Ctrl-C stops it and leaves, nothing is lost.")
        try:
            self._check_plan()
            while self._one_step():
                pass
        except (Left, EOFError):
            self.say(LEFT)
        except KeyboardInterrupt:
            self.say(f"\n{LEFT}")
            raise
        finally:
            self.let_go()

    def _check_plan(self) -> None:
        """Say at the start which bends of the plan the robot's joints cannot reach."""
        if self._robot is None:
            return
        plan = self.journal.session.setup.plan
        reach_deg = self._robot.reach_deg(plan.bend)
        for bend_deg in map(math.degrees, plan.bends_rad):
            if reach_deg < bend_deg - NEAR_DEG:
                self.say(f"! {self._too_far(bend_deg, reach_deg)}")

    def _too_far(self, bend_deg: float, reach_deg: float) -> str:
        name = "push_lambda_deg" if self._on_floor else "lambda_deg"
        return (
            f"bend {bend_deg:g} deg: joint limits and steering leave room for {reach_deg:g} deg. "
            f"Leave it out by `skip`; or plan less: {name} in "
            f"{self.journal.folder / 'session.toml'}"
        )

    @property
    def _on_floor(self) -> bool:
        return self.journal.session.setup.plan.on == "floor"

    def _one_step(self) -> bool:
        """Do one step; return False at the end."""
        self._read_again()
        self.step = step = next_step(self.journal.session, self._posture.bend_deg)
        self._told(self.journal.session, step)
        self._skip_doubted = False
        self.say("")
        self.say(step.say)
        if step.kind == "done":
            return False
        try:
            self._do(step)
        except (Again, BadInput, RecordingFailed, CommandRefused) as error:
            if step.kind == "gait":
                self.let_go()
            if not isinstance(error, Again):
                self.say(f"! {error}")
        return True

    def _read_again(self) -> None:
        """Read the files again, and say what somebody changed in session.toml meanwhile."""
        while True:
            try:
                changed = self.journal.read_again()
            except BadInput as error:
                self.say(f"! {error}")
                self.ask("  Enter when that is mended: ")
                continue
            for line in changed:
                self.say(f"session.toml: {line}")
            return

    def _do(self, step: Step) -> None:
        if step.kind in ("straight", "bend"):
            self._pose(step)
        elif step.kind == "gait":
            self._start(step)
        values = self._values(step)
        if step.kind == "gait" and self._robot and step.gait:
            values["omega_rad_s"] = self._robot.rate(step.gait)
            self.let_go()
        number = record_step(self.journal, step, values)
        self._posture.after(step)
        if number:
            self.say(f"kept as reading {number}")

    def _pose(self, step: Step) -> None:
        what = "straightens" if step.kind == "straight" else "bends"
        if self._robot is None:
            if step.kind == "straight":
                self.ask("Enter when it lies so: ")
            return
        if step.lambda_deg:
            self._say_reach(self._robot, step)
        self._ask_to_move(f"Enter {what} the robot (hands off): ")
        reach_deg = self._robot.reach_deg(step.bend) if step.lambda_deg else 0.0
        self._robot.pose(min(step.lambda_deg, reach_deg), step.bend)
        self._steer(self._robot, step)

    def _say_reach(self, robot: SessionRobot, step: Step) -> None:
        """Say where the joints reach less than a step's bend; wait where it is not near it."""
        while (reach_deg := robot.reach_deg(step.bend)) < step.lambda_deg:
            if reach_deg >= step.lambda_deg - NEAR_DEG:
                return self.say(
                    f"  Joint limits and steering leave room for {reach_deg:g} deg: it is bent so "
                    "far, and the protractor tells how far that is."
                )
            self.say(f"! {self._too_far(step.lambda_deg, reach_deg)}")
            self.ask("  skip, or quit: ")

    def _steer(self, robot: SessionRobot, step: Step) -> None:
        """Have the offset found that runs straight, before the first reading; it is kept."""
        left_out = "steering" in self.journal.session.skipped
        if step.lambda_deg or left_out or steered_rad(self.journal.session) is not None:
            return
        if self._on_floor:
            return self.say(
                "  Left and right keys bend every joint a little, at every prompt. Where a push "
                "turns the robot, steer against it before the next; each push keeps the offset."
            )
        self.say(
            "  Incline as for the first station, and raise the belt until the robot nearly holds "
            "its place: on a level belt it is carried off. Left and right keys bend every joint a "
            "little: steer until the robot runs straight by itself."
        )
        try:
            self.step = replace(step, key="steering")
            self.ask("  Enter keeps it; skip leaves the steering out alone: ")
        except Again:
            if "steering" in self.journal.session.skipped:
                return  # the pose is there: on to what is asked next
            raise
        finally:
            self.step = step
        self.say(f"  every joint has {math.degrees(robot.offset_rad):+.2f} deg from now on")

    def _start(self, step: Step) -> None:
        if self._robot is None or step.gait is None:
            return
        self._ask_to_move("Lay it straight. Enter starts the robot: ")
        self._robot.go(step.gait)

    def _ask_to_move(self, prompt: str) -> None:
        """Wait for Enter, typed now and not ahead."""
        self._terminal.forget()
        self.ask(prompt)

    def _values(self, step: Step) -> Values:
        """Ask for a step's numbers; what is out of line is asked about, never refused."""
        typed = None
        if step.kind in FILMED:
            typed = self._film_or_number(step)
            if isinstance(typed, Tracked):
                return typed
        begun_s, values = self._belt_set(step), Values()
        for field in step.asked:
            if field.column == "drift_m_s":
                values |= self._drift(field)
                continue
            likely, unit = field.likely, ""
            if field.column == "belt_speed_m_s":
                unit = self.journal.session.setup.instruments.belt_speed_unit
                if step.kind == "station":
                    likely = likely_belt(self.journal.session, step, values)
            values[field.column] = self.number(field, likely, typed=typed, unit=unit)
            typed = None
        if step.kind == "station" and "places" not in values:
            values["waited_s"] = round(self._clock_s() - begun_s, 1)
        if step.kind in ("station", "push"):
            values |= self._steering()
        return self._doubted(step, values)

    def _steering(self) -> Values:
        """Return the offset that steers, as a reading keeps it."""
        if self._robot is None:
            return {}
        return {"offset_deg": round(math.degrees(self._robot.offset_rad), 3)}

    def _film_or_number(self, step: Step) -> str | Tracked:
        """Return what a film showed; or what was typed instead, the first of a step's numbers.

        The pushes of a film are kept at once, however many.
        """
        text = ""
        while not text:
            text = self.ask(FILMED[step.kind])
        named = named_file(text)
        if named is None:
            return text
        if step.gait is None:
            cells = {**step.cells, **self._steering()}
            for kept in self._taken(*named, cells):
                self.say(f"  {kept.in_words()}")
            raise Again
        crawl = read_crawl(self.journal, named[0], step.gait, self._film)
        gains = ", ".join(f"{float(gain):.3f}" for gain in str(crawl["gains"]).split(","))
        self.say(
            f"  {float(crawl['speed_m_s']):.4f} m/s; joints' amplitudes over the commanded one, "
            f"from the tail: {gains}"
        )
        return crawl

    def _taken(self, path: Path, unit: str | None, cells: Values) -> list[Kept]:
        """Take the pushes of a file; ask for the unit of its lengths where it names none."""
        while True:
            try:
                return take_track(self.journal, path, unit, cells, self._film, self._note)
            except UnitMissing as error:
                likely = f"; likely: {', '.join(error.likely)}" if error.likely else ""
                names = ", ".join(LENGTH_UNITS)
                typed = self.ask(f"  unit of its lengths ({names}{likely}): ").strip()
                unit = typed if typed in LENGTH_UNITS else None

    def _note(self, text: str) -> None:
        self.say(f"  {text}")

    def _belt_set(self, step: Step) -> float:
        """Ask when a station's belt runs at its last speed; return that moment by the clock."""
        if step.kind == "station":
            self.ask(f"  Enter when the belt is set; let it settle {step.settle_s:.0f} s: ")
        return self._clock_s()

    def _doubted(self, step: Step, values: Values) -> Values:
        """Ask about each number that is not where it was expected, until a word keeps it."""
        kept: set[str] = set()
        while True:
            open_ = doubts(self.journal.session, step, values)
            open_ = [(field, likely) for field, likely in open_ if field.column not in kept]
            if not open_:
                return values
            field, likely = open_[0]
            value = float(values[field.column])
            why = f" ({field.why})" if field.why else ""
            answer = self.answer(
                f"  {field.words} {value:.4g} {field.unit}: expected {span(likely)}{why}. "
                "Type it anew, keep, or again: "
            )
            if answer == "keep":
                kept.add(field.column)
            elif answer:
                values[field.column] = self.number(field, typed=answer)

    def _drift(self, field: Field) -> Values:
        """Ask for the drift that is left; or for places over time, of a robot that still drifts."""
        question = f"  places in a film as s:m, {EXAMPLE}; or {field.words} ({field.unit}): "
        while True:
            text = self.ask(question, enter=True)
            if ":" not in text:  # no pairs of time and place
                return {field.column: self.number(field, typed=text)}
            try:
                places = tidy_places(text)
                return {"places": places, field.column: drifts(places)[0]}
            except BadInput as error:
                self.say(f"  ! {error}")


def steered_rad(session: Session) -> float | None:
    """Return the steering on every joint at the last reading that kept it; None before."""
    kept = [r for r in (*session.readings, *session.of("push")) if r.offset_rad is not None]
    return max(kept, key=lambda r: r.number).offset_rad if kept else None
