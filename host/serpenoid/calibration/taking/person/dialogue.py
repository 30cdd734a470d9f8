"""The person at the treadmill: each step said, each number asked for, each mistake mendable.

At every prompt there are words for undoing, redoing, skipping, pausing and leaving. Nothing goes
on by itself; when nobody answers, the robot's servos are let go and that is said.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping

from ....model.errors import BadInput, RecordingFailed, RobotError
from ...session import Session
from ...session_rows import reading_rows
from ..journal import Journal
from ..procedure import doubts, likely_belt, next_step, skipped_keys
from ..steps import Field, Step
from ..treadmill import Posture, record_step
from .prompt import Terminal
from .seat import Seat
from .typed import read_typed, span
from .typed_cells import FIELDS, values_of

PATIENCE_S = 300.0
HELP = """\
  undo            void the last reading         redo [N]   take the last reading, or number N, anew
  void N [why]    reading N is not to be used   restore N  use it again
  skip            leave this step out           note TEXT  keep a remark
  status          what was read so far          pause      servos off, until Enter
  quit            leave; go on any time         help       this"""
Values = dict[str, float | str]
Told = Callable[[Session, Step], None]


class Again(Exception):
    """Something else was done at a prompt: see where the session stands, and ask from there."""


class Left(Exception):
    """The person wants to leave."""


class Dialogue:
    """Take a session step by step with a person.

    seat: the robot, None if it is set by hand. told: called with session and step when a step
    begins, for pictures and the page. patience_s: how long a prompt waits before the servos are
    let go.
    """

    def __init__(
        self,
        journal: Journal,
        terminal: Terminal,
        seat: Seat | None = None,
        told: Told = lambda session, step: None,
        patience_s: float = PATIENCE_S,
    ):
        self._journal = journal
        self._terminal = terminal
        self._seat = seat
        self._told = told
        self._patience_s = patience_s
        self._posture = Posture()

    def run(self) -> None:
        """Go on until everything is done or the person leaves."""
        self._say("At every prompt: undo, redo, skip, pause, quit, help.")
        try:
            while self._one_step():
                pass
        except (Left, EOFError):
            self._say("Left. Everything read so far is kept; the same command goes on from here.")
        finally:
            self._let_go()

    def _one_step(self) -> bool:
        """Do one step; return False at the end."""
        skipped = skipped_keys(self._journal.events)
        step = next_step(self._journal.session, skipped, self._posture.bend_deg)
        self._told(self._journal.session, step)
        self._say("")
        self._say(step.say)
        if step.kind == "done":
            return False
        try:
            self._do(step)
        except Again:
            self._end_gait(step)
        except (BadInput, RecordingFailed) as error:
            self._end_gait(step)
            self._say(f"! {error}")
        return True

    def _end_gait(self, step: Step) -> None:
        if step.kind == "gait":
            self._let_go()

    def _do(self, step: Step) -> None:
        if step.kind in ("straight", "bend"):
            self._pose(step)
        elif step.kind == "gait":
            self._start(step)
        values = self._values(step)
        if step.kind == "gait" and self._seat and step.gait:
            values["omega_rad_s"] = self._seat.rate(step.gait)
            self._let_go()
        number = record_step(self._journal, step, values)
        self._posture.after(step)
        if number:
            self._say(f"kept as reading {number}")

    def _pose(self, step: Step) -> None:
        what = "straightens" if step.kind == "straight" else "bends"
        if self._seat is None:
            if step.kind == "straight":
                self._ask("Enter when it lies so: ", step)
            return
        self._ask(f"Enter {what} the robot (hands off): ", step)
        self._seat.pose(step.lambda_deg)

    def _start(self, step: Step) -> None:
        if self._seat is None or step.gait is None:
            return
        self._ask("Lay it straight. Enter starts the robot: ", step)
        self._seat.go(step.gait)

    def _values(self, step: Step) -> Values:
        """Ask for a step's numbers; what is out of line is asked about, never refused."""
        values: Values = {}
        begun_s = -math.inf
        for field in step.fields:
            if field.column == "drift_m_s":
                begun_s = time.monotonic()
                self._say(f"  let it settle {step.settle_s:.0f} s")
            likely = field.likely
            if field.column == "belt_speed_m_s":
                likely = likely_belt(self._journal.session, step, values)
            values[field.column] = self._number(field, likely, step)
        waited_s = time.monotonic() - begun_s
        if waited_s < step.settle_s / 2:
            waited = f"  only {waited_s:.0f} s of {step.settle_s:.0f}"
            question = f"{waited}: Enter keeps it, n reads again: "
            if self._ask(question, step).lower().startswith("n"):
                values["drift_m_s"] = self._number(step.fields[-1], None, step)
        return self._doubted(step, values)

    def _doubted(self, step: Step, values: Values) -> Values:
        """Ask once about each number that is not where it was expected."""
        for field, likely in doubts(self._journal.session, step, values):
            value = float(values[field.column])
            question = (
                f"  {field.words} {value:.4g} {field.unit}: expected {span(likely)}. "
                "Enter keeps it, or type it again: "
            )
            answer = self._ask(question, step)
            if answer and answer.lower() not in ("y", "yes", "k", "keep"):
                values[field.column] = self._read(answer, field, likely, step)
        return values

    def _number(self, field: Field, likely: tuple[float, float] | None, step: Step) -> float:
        return self._read(self._ask(f"  {field.words} ({field.unit}): ", step), field, likely, step)

    def _read(
        self, text: str, field: Field, likely: tuple[float, float] | None, step: Step
    ) -> float:
        """Return the number typed; what is none is told, and asked for again."""
        while True:
            try:
                typed = read_typed(text, field, likely)
                if not typed.question:
                    return typed.value
                answer = self._ask(f"  {typed.question} y, k keeps it, or type it again: ", step)
                if answer.lower() in ("y", "yes", "") and typed.meant is not None:
                    return typed.meant
                if answer.lower() in ("k", "keep"):
                    return typed.value
                text = answer
                continue
            except BadInput as error:
                self._say(f"  ! {error}")
            text = self._ask(f"  {field.words} ({field.unit}): ", step)

    def _ask(self, prompt: str, step: Step) -> str:
        """Return what was typed, once it is no command; raises Again and Left."""
        while True:
            line = self._terminal.ask(prompt, self._patience_s, self._tick)
            if line is None:
                self._nobody()
                continue
            if not self._do_word(line, step):
                return line

    def _nobody(self) -> None:
        if self._seat is None or not self._seat.powered:
            return
        self._let_go()
        text = f"nobody answered for {self._patience_s:g} s: servos off"
        self._journal.event("note", detail=text)
        self._say(f"! {text}; the pose is to be taken again")
        raise Again

    def _tick(self) -> None:
        if self._seat is None:
            return
        self._seat.tick()
        if self._seat.stopped:
            self._seat.stopped = False
            self._let_go()
            self._journal.event("note", detail="stopped from the page")
            self._say("\n! stopped from the page: servos off; the pose is to be taken again")
            raise Again

    def _let_go(self) -> None:
        """Let the servos go limp; the pose is then no longer known."""
        if self._seat is not None:
            try:
                self._seat.idle()
            finally:
                self._posture.bend_deg = None

    def _say(self, text: str) -> None:
        self._terminal.say(text)

    def _do_word(self, line: str, step: Step) -> bool:
        """Do what a command word says; return False if the line is none."""
        word, _, rest = line.partition(" ")
        name = _SHORT.get(word.lower(), word.lower())
        if name not in _COMMANDS:
            return False
        try:
            _COMMANDS[name](self, rest.strip(), step)
        except (BadInput, RecordingFailed) as error:
            self._say(f"  ! {error}")
        return True

    def _help(self, rest: str, step: Step) -> None:
        self._say(HELP)

    def _quit(self, rest: str, step: Step) -> None:
        raise Left

    def _skip(self, rest: str, step: Step) -> None:
        self._journal.event("skip", detail=step.key)
        self._say(f"  left out: {step.key}")
        raise Again

    def _pause(self, rest: str, step: Step) -> None:
        self._let_go()
        self._journal.event("pause", detail=rest)
        held = "" if self._seat is None else "; the servos are off"
        while self._terminal.ask(f"  paused{held}. Enter goes on: ", math.inf, self._tick) is None:
            pass
        self._journal.event("resume")
        raise Again

    def _note(self, rest: str, step: Step) -> None:
        self._journal.event("note", detail=rest)

    def _status(self, rest: str, step: Step) -> None:
        from ..procedure import progress

        session = self._journal.session
        for r in session.readings[-8:]:
            state = f"  void: {r.comment}" if r.voided else ""
            self._say(
                f"  {r.number:4}  bend {math.degrees(r.lambda_rad):.4g}  incline "
                f"{math.degrees(r.incline_rad):.2f} deg  belt {r.belt_speed_m_s:.3f}  drift "
                f"{r.drift_m_s:+.3f} m/s{state}"
            )
        for name, state in progress(session, skipped_keys(self._journal.events)):
            self._say(f"  {name:14} {state}")

    def _undo(self, rest: str, step: Step) -> None:
        skip = self._last_skip()
        if skip:
            self._journal.event("unskip", detail=skip)
            self._say(f"  no longer left out: {skip}")
            raise Again
        number = self._last_kept()
        self._journal.event("undo", number)
        self._say(f"  reading {number} is void")
        raise Again

    def _void(self, rest: str, step: Step) -> None:
        text, _, why = rest.partition(" ")
        self._journal.event("void", self._numbered(text), why)
        self._say(f"  reading {text} is void")
        raise Again

    def _restore(self, rest: str, step: Step) -> None:
        self._journal.event("restore", self._numbered(rest))
        self._say(f"  reading {rest} is used again")
        raise Again

    def _redo(self, rest: str, step: Step) -> None:
        number = self._numbered(rest) if rest else self._last_kept()
        row = next(r for r in reading_rows(self._journal.folder) if int(r["reading"]) == number)
        if row["kind"] not in FIELDS:
            raise BadInput(f"reading {number} is of a kind that cannot be redone here")
        self._say(f"  reading {number} anew; Enter keeps a value as it was")
        values = values_of(row) | self._anew(row, step)
        new = self._journal.add(row["kind"], values, replaces=number)
        self._say(f"  reading {new} is kept in place of {number}")
        raise Again

    def _anew(self, row: Mapping[str, str], step: Step) -> Values:
        """Ask for a row's numbers again."""
        values: Values = {}
        for field in FIELDS[row["kind"]]:
            old = row[field.column]
            if not old or field.column.startswith("speed"):
                continue
            text = self._ask(f"  {field.words} ({old} {field.unit}): ", step)
            if text:
                values[field.column] = self._read(text, field, None, step)
        if row["kind"] == "gait" and row["distance_m"]:
            both = values_of(row) | values
            watch = self._journal.session.setup.stopwatch
            values["speed_m_s"], values["speed_sigma_m_s"] = watch.speed(
                float(both["distance_m"]), float(both["duration_s"])
            )
        return values

    def _numbered(self, text: str) -> int:
        if not text.isdecimal() or int(text) not in self._journal.numbers:
            there = max(self._journal.numbers, default=0)
            raise BadInput(f"{text!r} is no reading's number; there are 1 to {there}; try `status`")
        return int(text)

    def _last_skip(self) -> str:
        """Return the step that was left out since the last reading, "" if none was."""
        rows = reading_rows(self._journal.folder)
        since = rows[-1]["time_utc"] if rows else ""
        skipped = skipped_keys(self._journal.events)
        late = [e for e in self._journal.events if e.event == "skip" and e.time_utc > since]
        return next((e.detail for e in reversed(late) if e.detail in skipped), "")

    def _last_kept(self) -> int:
        s = self._journal.session
        kept = [r.number for part in (s.readings, s.zeros, s.bends, s.gait_runs)
                for r in part if not r.voided]  # fmt: skip
        if not kept:
            raise BadInput("there is no reading yet")
        return max(kept)


_COMMANDS: dict[str, Callable[[Dialogue, str, Step], None]] = {
    name: getattr(Dialogue, f"_{name}")
    for name in (
        "help",
        "quit",
        "skip",
        "pause",
        "note",
        "status",
        "undo",
        "void",
        "restore",
        "redo",
    )
}
_SHORT = {"q": "quit", "exit": "quit", "?": "help", "u": "undo"}


def held_dialogue(dialogue: Dialogue, terminal: Terminal) -> bool:
    """Run a dialogue; return whether it ended well: a lost robot is told, and nothing is lost."""
    try:
        dialogue.run()
    except RobotError as error:
        terminal.say(
            f"! the robot: {error}\n  Everything read so far is kept; the same command goes on."
        )
        return False
    return True
