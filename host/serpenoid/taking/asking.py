"""One person asked at one terminal: five words at every prompt, one way to doubt a number."""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, TypeVar

from ..base.errors import BadInput, RecordingFailed
from ..session.declaration import Field, Values
from ..session.journal import Journal
from .parse_number import first_number, off_in_words
from .steps import Doubts
from .terminal import Terminal

if TYPE_CHECKING:
    from .session_robot import SessionRobot

WORDS = "At every prompt: undo, skip, pause, quit, help."
HELP = """\
  undo     ask the question before again; at the first one: the last reading is void
  undo 7   reading 7 is void
  skip     leave this reading out, or take what stands in brackets
  pause    servos off, until Enter
  quit     leave; everything read so far is kept
What a prompt asks for may be typed in one line, as 2.3 0.45, or one by one."""
SHORT = {"q": "quit", "exit": "quit", "?": "help", "u": "undo"}
PATIENCE_S = 300.0
T = TypeVar("T")


def questions(fields: Sequence[Field], unit: str = "") -> str:
    """Return what is asked for some numbers; unit: of those that have it."""
    units = [unit if unit in field.units else field.unit for field in fields]
    return "; ".join(f"{f.words} ({u})" for f, u in zip(fields, units, strict=True))


class Undo(Exception):
    """The person takes back what was before the first question."""


class Skip(Exception):
    """The person leaves this reading out."""


class Left(Exception):
    """The person wants to leave."""


class Again(Exception):
    """See where the session stands, and ask from there."""


class Asker:
    """Ask a person, who may type a word of HELP instead of any answer.

    robot: None if it is set by hand. patience_s: how long a prompt waits before its servos are let
    go. journal: of the session whose readings `undo 7` voids; None where there is none yet.
    answered_s: when the last answer came, by clock_s.
    """

    def __init__(
        self,
        terminal: Terminal,
        journal: Journal | None = None,
        robot: SessionRobot | None = None,
        patience_s: float = PATIENCE_S,
        clock_s: Callable[[], float] = time.monotonic,
    ):
        self._terminal, self._journal, self._robot = terminal, journal, robot
        self._patience_s, self._clock_s = patience_s, clock_s
        self._given = list[tuple[str, float]]()
        self._replay = deque[tuple[str, float]]()
        self._rest = ""  # of a line of several numbers
        self.answered_s = 0.0

    def say(self, text: str) -> None:
        """Show a line or more."""
        if not self._replay:
            self._terminal.say(text)

    def form(self, fill: Callable[[], T]) -> T:
        """Return what a function makes of the answers that it asks for.

        After `undo` and after an answer that cannot be, it runs again on the answers before that
        one. Raises Undo where there is none before, Skip, Left and Again.
        """
        self._given = []
        while True:
            self._replay, self._rest = deque(self._given), ""
            try:
                return fill()
            except Undo:
                if not self._given:
                    raise
            except BadInput as error:
                if not self._given:
                    raise
                self.say(f"  ! {error}")
            self._given.pop()

    def confirm(self, prompt: str, *, ahead: bool = True) -> None:
        """Wait for Enter alone; ahead: it may have been typed before."""
        self.form(lambda: self._entered(prompt, ahead))

    def _entered(self, prompt: str, ahead: bool) -> None:
        if not ahead:
            self._terminal.forget()
        text = self.ask(prompt)
        if text:  # "no" must not start a robot, and a number must not be lost
            raise BadInput(f"{text!r} is no answer to this; press Enter alone, or type help")

    def ask(self, prompt: str, usual: str = "") -> str:
        """Return an answer, usual for Enter and skip; raises Undo, Skip, Left and Again."""
        if self._replay:
            line, self.answered_s = self._replay.popleft()
            return line
        line = None
        while line is None:
            line = self._terminal.ask(prompt, self._patience_s, self._tick)
            if line is None:
                self._nobody()
            else:
                line = self._obeyed(line, usual)
        self.answered_s = self._clock_s()
        self._given.append((line, self.answered_s))
        return line

    def numbers(self, fields: Sequence[Field], typed: str = "", unit: str = "") -> Values:
        """Return the fields' numbers, by their columns. typed: the answer that is there already.

        unit: of a number without one, where the field has that unit.
        """
        values = Values()
        self._rest = typed
        for k, field in enumerate(fields):
            text = self._rest or self.ask(f"  {questions(fields[k:], unit)}: ")
            in_unit = unit if unit in field.units else ""
            values[field.column], self._rest = first_number(text, field, in_unit)
        if self._rest:
            raise BadInput(f"{self._rest!r} is too much; {len(fields)} number(s) are asked for")
        return values

    def sure(self, values: Values, doubts: Callable[[Values], Doubts], unit: str = "") -> Values:
        """Return values once each number is where it is expected, or kept by the person."""
        kept = set[str]()
        while True:
            found = [(field, likely) for field, likely in doubts(values)]
            found = [(field, likely) for field, likely in found if field.column not in kept]
            if not found:
                return values
            field, likely = found[0]
            off = off_in_words(float(values[field.column]), field, likely, unit)
            answer = self.ask(f"  {off}. Type it anew, or keep: ")
            if answer.lower() in ("keep", "k"):
                kept.add(field.column)
            elif answer:
                values = values | self.numbers([field], answer, unit)
            else:
                self._given.pop()  # Enter keeps nothing that is in doubt

    def let_go(self) -> None:
        """Let the servos go limp."""
        if self._robot is not None:
            self._robot.idle()

    def _obeyed(self, line: str, usual: str) -> str | None:
        """Return the answer that a line is, None for a word that was obeyed and goes on."""
        word, _, rest = line.strip().lower().partition(" ")
        word = SHORT.get(word, word)
        if rest and word == "undo":
            self._void(rest.strip())
        elif rest or word not in ("undo", "skip", "pause", "quit", "help"):
            return line or usual
        elif word == "skip" and usual:
            return usual
        elif word == "help":
            self._terminal.say(HELP)
        elif word == "pause":
            self._pause()
        else:
            raise {"undo": Undo, "skip": Skip, "quit": Left}[word]
        return None

    def _void(self, number: str) -> None:
        rows = {} if self._journal is None else self._journal.rows
        if self._journal is None or not number.isascii() or not number.isdecimal():
            return self.say(f"  ! no reading has the number {number!r}")
        if int(number) not in rows:
            return self.say(f"  ! there is no reading {number}; there are {len(rows)}")
        if self._note("undo", reading=int(number)):
            self.say(f"  reading {number} is void")
        return None

    def _pause(self) -> None:
        """Let the servos go until the person is back; the pose of a robot is then taken anew."""
        held = self._robot is not None and self._robot.powered
        self.let_go()
        self._note("pause")
        off = "" if self._robot is None else f"; {self._robot.without_pulses}"
        while self._terminal.ask(f"  paused{off}. Enter goes on: ", math.inf, self._tick) is None:
            pass
        self._note("resume")
        if held:
            raise Again

    def _nobody(self) -> None:
        if self._robot is not None and self._robot.powered:
            self._pulses_off(self._robot, f"nobody answered for {self._patience_s:g} s")

    def _tick(self) -> None:
        if self._robot is None:
            return
        self._robot.tick()
        if self._robot.stopped:
            self._robot.stopped = False
            self._pulses_off(self._robot, "stopped by a key")

    def _pulses_off(self, robot: SessionRobot, why: str) -> None:
        robot.idle()
        text = f"{why}: {robot.without_pulses}"
        self._terminal.say(f"\n! {text}; the pose is to be taken again")
        self._note("note", text)
        raise Again

    def _note(self, event: str, detail: str = "", reading: int = 0) -> bool:
        """Keep an event; say so, and return False, where the disk takes no more."""
        try:
            if self._journal is not None:
                self._journal.event(event, reading, detail)
        except RecordingFailed as error:
            self._terminal.say(f"  ! {error}")
            return False
        return True
