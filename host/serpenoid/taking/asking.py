"""One person asked at one terminal: five words at every prompt, one way to doubt a number."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping, Sequence
from typing import TypeVar

from ..base.checks import count_text
from ..base.errors import BadInput
from ..session.declaration import Field, Range, Values
from ..session.journal import Journal
from .parse_number import bare_unit, doubt_in_words, first_number
from .session_robot import SessionRobot
from .terminal import PATIENCE_S, Console

WORDS = "At every prompt: undo, skip, pause, quit, help."
HELP = """\
  undo     ask the question before again; at the first one: the last reading is void
  undo 7   reading 7 is void
  skip     leave this reading out, or take what stands in brackets
  pause    servos off, until the next Enter
  quit     leave; everything read so far is kept
What a prompt asks for may be typed in one line, as 2.3 0.45, or one by one."""
T = TypeVar("T")


class Undo(Exception):
    """The person takes back what was before the first question."""


class Skip(Exception):
    """The person leaves this reading out."""


class Quit(Exception):
    """The person wants to leave."""


class Restart(Exception):
    """See where the session stands, and ask from there."""


class Asker:
    """Ask a person, who may type a word of HELP instead of any answer.

    robot: None if it is set by hand. journal: of the session whose readings `undo 7` voids; None
    where there is none yet. belt_unit: of a belt's speed without one.
    """

    def __init__(
        self,
        terminal: Console,
        journal: Journal | None = None,
        robot: SessionRobot | None = None,
    ):
        self._terminal, self._journal, self._robot = terminal, journal, robot
        self._answers, self._replay = list[str](), deque[str]()
        self.belt_unit = ""

    def say(self, text: str) -> None:
        """Show a line or more."""
        if not self._replay:
            self._terminal.say(text)

    def form(self, fill: Callable[[], T]) -> T:
        """Return what a function makes of the answers that it asks for.

        After `undo` and after an answer that cannot be, it runs again on the answers before that
        one. Raises Undo where there is none before, Skip, Quit and Restart.
        """
        self._answers = []
        while True:
            self._replay = deque(self._answers)
            try:
                return fill()
            except (Undo, BadInput) as error:
                if not self._answers:
                    raise
                if isinstance(error, BadInput):
                    self.say(f"  ! {error}")
            self._answers.pop()

    def confirm(self, prompt: str, *, moves: bool = False) -> None:
        """Wait for Enter alone; where it moves the robot, it may not have been typed before."""
        while True:
            if moves:
                self._terminal.forget()
            text = self.ask(prompt)
            if not text:
                return
            # "no" must not start a robot, and a number must not be lost.
            self.say(f"  ! {text!r} is no answer to this; press Enter alone, or type help")

    def ask(self, prompt: str, usual: str = "") -> str:
        """Return an answer, usual for Enter and skip; raises Undo, Skip, Quit and Restart."""
        if self._replay:
            return self._replay.popleft()
        answer = None
        while answer is None:
            line = self._terminal.ask(prompt, self._tick)
            if line is not None:
                answer = self._obey(line, usual)
            else:
                self._let_go(f"nobody answered for {PATIENCE_S:g} s")
        self._answers.append(answer)
        return answer

    def numbers(self, fields: Sequence[Field], line: str = "") -> Values:
        """Return the fields' numbers, by their columns; line: the answer that is there already.

        Once a line ends, what has a usual value is not asked for.
        """
        values = Values()
        for k, field in enumerate(fields):
            if not line and not (k and field.usual is not None):
                words = [f"{f.words} ({bare_unit(f, self.belt_unit)})" for f in fields[k:]]
                line = self.ask(f"  {'; '.join(words)}: ")
            values[field.column], line = first_number(line, field, self.belt_unit)
        if line:
            raise BadInput(f"{line!r} is too much; {count_text(len(fields), 'number')} will do")
        return values

    def sure(
        self,
        fields: Sequence[Field],
        values: Values,
        expected: Callable[[Values], Mapping[str, Range | None]],
    ) -> Values:
        """Return values once each number is where it is expected, or confirmed by the person.

        expected: returns the ranges that the fields' numbers are expected in, by their columns.
        """
        for field in fields:
            while (span := expected(values)[field.column]) and field.column in values:
                number = float(values[field.column])
                if span[0] <= number <= span[1]:
                    break
                doubt = doubt_in_words(number, field, span)
                answer = self.ask(f"  {doubt}. Type it anew, or keep: ")
                if answer.lower() == "keep":
                    break
                if answer:
                    values = values | self.numbers([field], answer)
                else:
                    self._answers.pop()  # Enter keeps nothing that is in doubt
        return values

    def _obey(self, line: str, usual: str) -> str | None:
        """Return the answer that a line is, None for a word that was obeyed and goes on."""
        word, _, number = line.strip().lower().partition(" ")
        if number and word == "undo":
            self._void(number.strip())
        elif number or word not in ("undo", "skip", "pause", "quit", "help"):
            return line or usual
        elif word == "skip" and usual:
            return usual
        elif word == "help":
            self._terminal.say(HELP)
        elif word == "pause":
            self._let_go("paused")
        else:
            raise {"undo": Undo, "skip": Skip, "quit": Quit}[word]
        return None

    def _void(self, number: str) -> None:
        if self._journal is None or number not in map(str, self._journal.rows):
            return self.say(f"  ! there is no reading {number}")
        self._journal.event("undo", int(number))
        return self.say(f"  reading {number} is void")

    def _tick(self) -> None:
        if self._robot is not None:
            self._robot.tick()
            if self._robot.stopped:
                self._let_go("stopped by a key")

    def _let_go(self, why: str) -> None:
        """End the pulses of a robot that is powered, and raise Restart: its pose is lost."""
        if self._robot is None or not self._robot.powered:
            return
        self._robot.idle()
        text = f"{why}: {self._robot.without_pulses}"
        self._terminal.say(f"\n! {text}; the pose is to be taken again")
        if self._journal is not None:
            self._journal.event("note", detail=text)
        raise Restart
