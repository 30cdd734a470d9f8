"""A line from a person, with a limit on how long nobody answers."""

from __future__ import annotations

import shutil
import sys
import textwrap
import time
from collections.abc import Callable, Mapping
from typing import Protocol

from ..base import system
from ..base.files import visible
from ..robot.tools.keys import KeyReader

TICK_S = 0.5


class Terminal(Protocol):
    """Where a dialogue is held."""

    def say(self, text: str) -> None:
        """Show a line or more."""
        ...

    def ask(self, prompt: str, patience_s: float, tick: Callable[[], None]) -> str | None:
        """Return a line, None if none came in time; raises EOFError at the end of the input.

        tick is called twice a second while waiting.
        """
        ...

    def forget(self) -> None:
        """Drop what was typed ahead: what is asked next may set a robot in motion."""
        ...


class Console:
    """Standard input and output; works behind a pipe, too.

    keys: what single keys do while a line is asked for at a terminal, key -> function that returns
    what to show; such as those that steer a robot. A space is one only where a line begins.
    """

    def __init__(self) -> None:
        self.keys: Mapping[str, Callable[[], str]] = {}
        self._reader: KeyReader | None = None
        self._pending = b""
        self._ended = False

    def say(self, text: str) -> None:
        """Print, long lines wrapped at words."""
        width = max(shutil.get_terminal_size((100, 24)).columns - 1, 20)
        for line in visible(text).split("\n"):
            print("\n".join(textwrap.wrap(line, width)) if len(line) > width else line, flush=True)

    def ask(self, prompt: str, patience_s: float, tick: Callable[[], None]) -> str | None:
        """Print the prompt and wait for a line."""
        print(visible(prompt), end="", flush=True)
        if sys.stdin.isatty() and (self.keys or system.WINDOWS):  # whose lines cannot be waited for
            return self._ask_by_keys(prompt, patience_s, tick)
        end_s = time.monotonic() + patience_s
        while b"\n" not in self._pending and not self._ended:
            if time.monotonic() > end_s:
                print(flush=True)
                return None
            data = system.read_input(min(TICK_S, patience_s))
            self._ended = data == b""
            self._pending += data or b""
            if data is None:
                tick()
        if self._ended and not self._pending:
            print(flush=True)
            raise EOFError
        line, _, self._pending = self._pending.partition(b"\n")
        if not sys.stdin.isatty():
            print(flush=True)
        return line.decode("utf-8", "replace").strip()

    def _ask_by_keys(self, prompt: str, patience_s: float, tick: Callable[[], None]) -> str | None:
        """Return a line as ask does, each key heard at once: some do something by themselves."""
        self._reader = self._reader or KeyReader()
        line, end_s = "", time.monotonic() + patience_s
        with system.single_keys():
            while True:
                key = self._reader(min(TICK_S, patience_s))
                if key == "enter" or (key == "end" and line):
                    print(flush=True)
                    return line.strip()
                if key == "end":
                    print(flush=True)
                    raise EOFError
                if not key:
                    if time.monotonic() > end_s:
                        print(flush=True)
                        return None
                    tick()
                    continue
                if key in self.keys and not (key == " " and line):
                    self._act(key, line, prompt)
                    tick()  # which tells at once of a robot that was stopped
                else:
                    line = self._after(key, line)

    def _act(self, key: str, line: str, prompt: str) -> None:
        """Do what a key does, and show it before the line."""
        shown = f"{prompt.lstrip()}{line}"[-40:]
        print(f"\r\x1b[K  [{self.keys[key]()}] {shown}", end="", flush=True)

    def _after(self, key: str, line: str) -> str:
        """Return the line after one more key, and show it."""
        if key == "backspace":
            print("\b \b" if line else "", end="", flush=True)
            return line[:-1]
        elif key == "\x15":  # Ctrl-U
            print("\b \b" * len(line), end="", flush=True)
            return ""
        elif len(key) == 1 and key.isprintable():
            print(key, end="", flush=True)
            return line + key
        return line

    def forget(self) -> None:
        """Drop what was typed ahead at a terminal; what a pipe holds was meant in this order."""
        if self._reader is not None:
            self._reader.forget()
        if sys.stdin.isatty():
            self._pending = b""
            system.forget_input()
