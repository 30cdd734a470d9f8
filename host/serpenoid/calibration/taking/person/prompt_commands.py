"""Commands at every prompt: corrections, remarks, and ways to leave."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Protocol

from ....model.errors import BadInput, RecordingFailed
from ...kinds.declaration import READ, Field, Word
from ...kinds.rows import cells_of, kind_of
from ...session_rows import reading_rows
from ..journal import Journal
from ..parse_number import redone
from ..procedure import progress, skipped_keys, step_in_words
from ..steps import Step

HELP = """\
  undo            void the last reading         redo [N]   take the last reading, or number N, anew
  void N [why]    reading N is not to be used   restore N  use it again
  skip            leave this step out           note TEXT  keep a remark
  status          what was read so far          pause      pulses off, until Enter
  quit            leave; go on any time         help       this"""
SHORT = {"q": "quit", "exit": "quit", "?": "help", "u": "undo"}
Values = dict[str, float | str]


class Again(Exception):
    """Something else was done at a prompt: see where the session stands, and ask from there."""


class Left(Exception):
    """The person wants to leave."""


class Talk(Protocol):
    """The dialogue that the commands are typed in."""

    @property
    def journal(self) -> Journal:
        """Return the session that is written to."""
        ...

    def say(self, text: str) -> None:
        """Show a line or more."""
        ...

    def ask(self, prompt: str, step: Step) -> str:
        """Return what was typed, once it is none of these commands."""
        ...

    def read(
        self, text: str, field: Field, likely: tuple[float, float] | None, step: Step
    ) -> float:
        """Return the number typed; what is none is told, and asked for again."""
        ...

    def hold(self, why: str) -> None:
        """Let the servos go until the person is back."""
        ...


class PromptCommands:
    """Obey the commands; every one of them is there at every prompt."""

    def __init__(self, talk: Talk):
        self._talk = talk
        self._journal = talk.journal
        self._all: dict[str, Callable[[str, Step], None]] = {
            name: getattr(self, f"_{name}")
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

    def obey(self, line: str, step: Step) -> bool:
        """Do what a word says; return False if the line is none. Raises Again and Left."""
        word, _, rest = line.partition(" ")
        name = SHORT.get(word.lower(), word.lower())
        if name not in self._all:
            return False
        try:
            self._all[name](rest.strip(), step)
        except (BadInput, RecordingFailed) as error:
            self._talk.say(f"  ! {error}")
        return True

    def _help(self, rest: str, step: Step) -> None:
        self._talk.say(HELP)

    def _quit(self, rest: str, step: Step) -> None:
        raise Left

    def _skip(self, rest: str, step: Step) -> None:
        self._journal.event("skip", max(self._journal.numbers, default=0), step.key)
        self._talk.say(f"  left out: {step_in_words(step.key)}")
        if step.kind == "zero":
            self._talk.say(
                "  ! without a zero, 0.1 deg that nobody sees is 6 % of the 2005 robot's ft0; the "
                "fit then counts the error that session.toml states. `undo` brings the step back."
            )
        raise Again

    def _pause(self, rest: str, step: Step) -> None:
        self._talk.hold(rest)
        raise Again

    def _note(self, rest: str, step: Step) -> None:
        if not rest:
            raise BadInput("type the remark after the word: note warm room")
        self._journal.event("note", detail=rest)
        self._talk.say("  noted")

    def _status(self, rest: str, step: Step) -> None:
        session = self._journal.session
        for kind, r in session.numbered[-8:]:
            state = f"  void: {r.comment}" if r.voided else ""
            self._talk.say(f"  {r.number:4}  {'  '.join(kind.describe(r))}{state}")
        parts = progress(session, skipped_keys(self._journal.events))
        wide = max(len(name) for name, _ in parts)
        for name, state in parts:
            self._talk.say(f"  {name:{wide}}  {state}")

    def _undo(self, rest: str, step: Step) -> None:
        skip = self._last_skip()
        if skip:
            self._journal.event("unskip", detail=skip)
            self._talk.say(f"  no longer left out: {step_in_words(skip)}")
            raise Again
        number = self._last_kept()
        self._journal.event("undo", number)
        self._talk.say(f"  reading {number} is void")
        raise Again

    def _void(self, rest: str, step: Step) -> None:
        text, _, why = rest.partition(" ")
        self._journal.event("void", self._numbered(text), why)
        self._talk.say(f"  reading {text} is void")
        raise Again

    def _restore(self, rest: str, step: Step) -> None:
        self._journal.event("restore", self._numbered(rest))
        self._talk.say(f"  reading {rest} is used again")
        raise Again

    def _redo(self, rest: str, step: Step) -> None:
        number = self._numbered(rest) if rest else self._last_kept()
        row = next(r for r in reading_rows(self._journal.folder) if int(r["reading"]) == number)
        self._talk.say(f"  reading {number} anew; Enter keeps a value as it was")
        found = self._anew(row, step)
        values = redone(row["kind"], row, found, self._journal.session.setup)
        new = self._journal.redo(number, values)
        self._talk.say(f"  reading {new} is kept in place of {number}")
        raise Again

    def _anew(self, row: Mapping[str, str], step: Step) -> Values:
        """Ask for a row's numbers again; what the plan or the protractor told stays."""
        values: Values = {}
        there = cells_of(row)
        for field in kind_of(row["kind"]).fields:
            if field.source != READ or not there.get(field.column):
                continue
            if isinstance(field, Word):
                text = self._talk.ask(f"  {field.column} ({there[field.column]}): ", step)
                values |= {field.column: field.read(text)} if text else {}
                continue
            old = float(there[field.column])
            text = self._talk.ask(f"  {field.words} ({old:.4g} {field.unit}): ", step)
            if text:
                values[field.column] = self._talk.read(text, field, None, step)
        return values

    def _numbered(self, text: str) -> int:
        if not text.isdecimal() or int(text) not in self._journal.numbers:
            there = max(self._journal.numbers, default=0)
            known = f"there are 1 to {there}" if there else "there are none yet"
            raise BadInput(f"{text!r} is no reading's number; {known}; try `status`")
        return int(text)

    def _last_skip(self) -> str:
        """Return the step that was left out since the last reading, "" if none was.

        By the number of that reading, which `skip` keeps: clocks may be set back.
        """
        last = max(self._journal.numbers, default=0)
        skipped = skipped_keys(self._journal.events)
        late = [e for e in self._journal.events if e.event == "skip" and e.reading == last]
        return next((e.detail for e in reversed(late) if e.detail in skipped), "")

    def _last_kept(self) -> int:
        kept = [r.number for _, r in self._journal.session.numbered if not r.voided]
        if not kept:
            raise BadInput("there is no reading yet")
        return max(kept)
