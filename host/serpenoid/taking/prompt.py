"""A prompt: a line asked for, and words at every one to correct, to remark and to leave."""

from __future__ import annotations

import math

from ..base.errors import BadInput, RecordingFailed
from ..session.declaration import Field, Range
from ..session.journal import Journal
from .parse_number import parse_number
from .procedure import ZERO_BEFORE, progress, step_in_words
from .session_robot import SessionRobot
from .steps import Step
from .terminal import Terminal
from .treadmill import Posture

HELP = """\
  undo            void the last reading         void N [why]    reading N is not to be used
  skip            leave this step out           note TEXT  keep a remark
  status          what was read so far          pause      pulses off, until Enter
  quit            leave; go on any time         help       this"""
SHORT = {"q": "quit", "exit": "quit", "?": "help", "u": "undo"}
PATIENCE_S = 300.0


class Again(Exception):
    """Something else was done at a prompt: see where the session stands, and ask from there."""


class Left(Exception):
    """The person wants to leave."""


class Prompt:
    """Ask a person at a terminal, who may type a word of HELP instead of an answer.

    robot: None if it is set by hand. patience_s: how long a prompt waits before its servos are let
    go. step: that the person is at.
    """

    def __init__(
        self,
        journal: Journal,
        terminal: Terminal,
        robot: SessionRobot | None = None,
        patience_s: float = PATIENCE_S,
    ):
        self.journal = journal
        self._terminal, self._robot, self._patience_s = terminal, robot, patience_s
        self._posture = Posture()
        self.step = Step("", "identity", "")
        self._skip_doubted = False

    def say(self, text: str) -> None:
        """Show a line or more."""
        self._terminal.say(text)

    def ask(self, prompt: str, *, enter: bool = False) -> str:
        """Return what was typed, once it is none of the words; raises Again and Left.

        enter: Enter answers this question, too.
        """
        while True:
            line = self._terminal.ask(prompt, self._patience_s, self._tick)
            if line is None:
                self._nobody()
            elif not self._obeyed(line, enter):
                self._skip_doubted = False
                return line

    def answer(self, question: str) -> str:
        """Return an answer to a doubt, "keep" for its short forms; `again` raises Again."""
        answer = self.ask(question).lower()
        if answer in ("again", "a"):
            self.say("  again, from the start of this step")
            raise Again
        return "keep" if answer in ("k", "keep") else answer

    def number(
        self,
        field: Field,
        likely: Range | None = None,
        *,
        prompt: str = "",
        typed: str | None = None,
        usual: float | None = None,
        unit: str = "",
    ) -> float:
        """Return the number asked for; what is none is told, and asked for again.

        typed: the answer, where that is there already. usual: what Enter means, where that is not
        as the field says. unit: of a number without one, where that is not the field's.
        """
        prompt = prompt or f"  {field.words} ({unit or field.unit}): "
        enter = field.usual is not None
        text = self.ask(prompt, enter=enter) if typed is None else typed
        while text or usual is None:
            try:
                number = parse_number(text, field, likely, unit)
            except BadInput as error:
                self.say(f"  ! {error}")
                text = self.ask(prompt, enter=enter)
                continue
            if not number.question:
                return number.value
            answer = self.ask(f"  {number.question} [Y/n] ", enter=True).lower()
            if answer in ("", "y", "yes") and number.meant is not None:
                return number.meant
            if answer in ("n", "no"):
                self.say("  then type it anew, with its unit")
                answer = self.ask(prompt, enter=enter)
            text = answer
        return usual

    def let_go(self) -> None:
        """Let the servos go limp; the pose is then no longer known."""
        if self._robot is not None:
            try:
                self._robot.idle()
            finally:
                self._posture.bend_deg = None

    def _nobody(self) -> None:
        if self._robot is not None and self._robot.powered:
            self._pulses_off(f"nobody answered for {self._patience_s:g} s")

    def _tick(self) -> None:
        if self._robot is None:
            return
        self._robot.tick()
        if self._robot.stopped:
            self._robot.stopped = False
            self._pulses_off("stopped by a key")

    def _pulses_off(self, why: str) -> None:
        self.let_go()
        text = f"{why}: {self._off}"
        self.say(f"\n! {text}; the pose is to be taken again")
        self.journal.event("note", detail=text)
        raise Again

    @property
    def _off(self) -> str:
        """Return in words what the servos do once they are let go; "" of a robot set by hand."""
        return "" if self._robot is None else self._robot.without_pulses

    def _obeyed(self, line: str, enter: bool) -> bool:
        """Do what a word says; return False if the line is none. Raises Again and Left."""
        word, _, rest = line.partition(" ")
        word = word.lower()
        word, rest = SHORT.get(word, word), rest.strip()
        obey = getattr(self, f"_do_{word}", None)
        if obey is None:
            return False
        try:
            obey(rest, enter) if word == "skip" else obey(rest)
        except (BadInput, RecordingFailed) as error:
            self.say(f"  ! {error}")
        return True

    def _do_skip(self, rest: str, enter: bool) -> None:
        step = self.step
        if not step.key:
            raise BadInput("this is no step of the plan; it cannot be left out")
        zero_sigma_rad = self.journal.session.setup.instruments.incline_zero_sigma_rad
        if not self._skip_doubted and (doubt := _skip_doubt(step, enter, zero_sigma_rad)):
            self._skip_doubted = True
            return self.say(doubt)
        self.journal.event("skip", self.journal.last, step.key)
        self.say(f"  left out: {step_in_words(step.key)}")
        if step.key == "straight":
            self.say(
                "  ! that is all of the straight stations, without which nothing can be fitted. "
                "`undo` brings them back."
            )
        raise Again

    def _do_help(self, rest: str) -> None:
        self.say(HELP)

    def _do_quit(self, rest: str) -> None:
        raise Left

    def _do_pause(self, rest: str) -> None:
        """Let the servos go until the person is back."""
        self.let_go()
        self.journal.event("pause", detail=rest)
        prompt = f"  paused{'; ' * bool(self._off)}{self._off}. Enter goes on: "
        while self._terminal.ask(prompt, math.inf, self._tick) is None:
            pass
        self.journal.event("resume")
        raise Again

    def _do_note(self, rest: str) -> None:
        if not rest:
            raise BadInput("type the remark after the word: note warm room")
        self.journal.event("note", detail=rest)
        self.say("  noted")

    def _do_status(self, rest: str) -> None:
        session = self.journal.session
        for r in session.numbered[-8:]:
            state = f"  void: {r.comment}" if r.voided else ""
            self.say(f"  {r.number:4}  {'  '.join(r.in_words())}{state}")
        parts = progress(session)
        wide = max(len(name) for name, _ in parts)
        for name, state in parts:
            self.say(f"  {name:{wide}}  {state}")

    def _do_undo(self, rest: str) -> None:
        skip = self._last_skip()
        if skip:
            self.journal.event("unskip", detail=skip)
            self.say(f"  no longer left out: {step_in_words(skip)}")
        else:
            number = self._last_kept()
            self.journal.event("undo", number)
            self.say(f"  reading {number} is void")
        raise Again

    def _do_void(self, rest: str) -> None:
        text, _, why = rest.partition(" ")
        self.journal.event("void", self._numbered(text), why)
        self.say(f"  reading {text} is void")
        raise Again

    def _numbered(self, text: str) -> int:
        if not text.isdecimal() or int(text) not in self.journal.rows:
            known = (
                f"there are 1 to {self.journal.last}" if self.journal.rows else "there are none yet"
            )
            raise BadInput(f"{text!r} is no reading's number; {known}; try `status`")
        return int(text)

    def _last_skip(self) -> str:
        """Return the step that was left out since the last reading, "" if none was.

        By the number of that reading, which `skip` keeps: clocks may be set back.
        """
        session, last = self.journal.session, self.journal.last
        late = [e.detail for e in session.events if e.event == "skip" and e.reading == last]
        return next((key for key in reversed(late) if key in session.skipped), "")

    def _last_kept(self) -> int:
        kept = [r.number for r in self.journal.session.numbered if not r.voided]
        if not kept:
            raise BadInput("there is no reading yet")
        return max(kept)


def _skip_doubt(step: Step, enter: bool, zero_sigma_rad: float) -> str:
    """Return what `skip` leaves out where one may mean less, or not know it; "" where nobody can.

    zero_sigma_rad: that is assumed of an inclinometer's zero that nobody measured.
    """
    if step.key == ZERO_BEFORE:
        return (
            "  ! zeros of phones and cheap inclinometers are 0.3 to 0.5 deg off, and 0.3 deg are "
            "17 % of the 2005 robot's ft0. Two readings take a minute. skip once more leaves them "
            f"out: {math.degrees(zero_sigma_rad):.2g} deg are then assumed."
        )
    if step.kind == "straight" and step.key != "steering":
        what = "pushes" if step.key.startswith("pushes") else "stations"
        return (
            f"  ! skip leaves out all of the straight {what}, not only this pose: type it once "
            "more for that. Enter goes on in this pose."
        )
    if enter:
        return (
            "  ! skip leaves out the whole reading, with what was typed: type it once more for "
            "that. Enter answers this question."
        )
    return ""
