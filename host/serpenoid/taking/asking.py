"""Ask a person at the terminal: any prompt takes five command words; odd numbers are queried."""

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
  undo     ask the previous question again; at the first one, void the last reading
  undo 7   void reading 7
  skip     leave this reading out, or take the value in brackets
  pause    servos off, until the next Enter
  quit     leave; everything read so far is kept
What a prompt asks for may be typed in one line, as 2.3 0.45, or one by one."""
T = TypeVar("T")


class Undo(Exception):
    """The person typed undo at the first question of a form."""


class Skip(Exception):
    """The person typed skip, to leave this reading out."""


class Quit(Exception):
    """The person typed quit."""


class Restart(Exception):
    """The robot lost its pose: the session is to be continued from its next step."""


class Asker:
    """Ask a person for numbers and words; a word of HELP may be typed in place of any answer.

    journal: the session whose readings `undo 7` voids; None if it does not exist yet. robot: the
    board that moves it; None if a person bends it by hand. belt_unit: unit of belt speeds that are
    typed without one.
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
        """Show some lines, unless earlier answers are being replayed."""
        if not self._replay:
            self._terminal.say(text)

    def form(self, fill: Callable[[], T]) -> T:
        """Return fill(), a function that asks questions of this asker.

        After `undo`, and after an answer that fill refuses with BadInput, it runs again: the
        answers but for the last one are replayed, and the person is asked that question anew.
        Raises Undo or BadInput if there is no answer yet, and Skip, Quit and Restart.
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
        """Wait for Enter alone; moves: it starts the robot, so what was typed ahead is dropped."""
        while True:
            if moves:
                self._terminal.forget()
            text = self.ask(prompt)
            if not text:
                return
            # A "no" must not start a robot, and a number typed here would be lost.
            self.say(f"  ! {text!r} is no answer to this; press Enter alone, or type help")

    def ask(self, prompt: str, usual: str = "") -> str:
        """Return an answer; Enter and skip give usual. Raises Undo, Skip, Quit and Restart."""
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
        """Return the fields' numbers in their columns' units, column -> number; raises BadInput.

        line: an answer that the person has given already. Several numbers may be typed in one line.
        After the first number, fields with a usual value are not asked for.
        """
        values = Values()
        for index, field in enumerate(fields):
            if not line and not (index and field.usual is not None):
                words = [f"{f.words} ({bare_unit(f, self.belt_unit)})" for f in fields[index:]]
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
        """Return values after the person has corrected or confirmed each doubtful number.

        expected: returns the range in which each field's number is expected, column -> range.
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
                    self._answers.pop()  # Enter does not confirm a doubtful number.
        return values

    def _obey(self, line: str, usual: str) -> str | None:
        """Return the answer in a line; None after a command word that leaves the question open."""
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
        """End the pulses of a powered robot, which loses its pose, and raise Restart."""
        if self._robot is None or not self._robot.powered:
            return
        self._robot.idle()
        text = f"{why}: {self._robot.without_pulses}"
        self._terminal.say(f"\n! {text}; the pose is to be taken again")
        if self._journal is not None:
            self._journal.event("note", detail=text)
        raise Restart
