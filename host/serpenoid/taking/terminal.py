"""Standard input and output of a dialogue, with a limit on the time without an answer."""

from __future__ import annotations

import shutil
import sys
import textwrap
import time
from collections.abc import Callable, Mapping
from contextlib import nullcontext

from ..base import system
from ..base.files import visible
from ..robot.tools.keys import KeyReader

PATIENCE_S = 300.0  # time without an answer, s, after which the servos lose power


class Console:
    """Standard input and output; works behind a pipe, too.

    keys: keys that act while a line is typed at a terminal, such as those that steer a robot; key
    -> function that acts and returns what to show. A space acts only at the start of a line.
    """

    def __init__(self) -> None:
        self.keys: Mapping[str, Callable[[], str]] = {}
        self._reader = KeyReader()

    def say(self, text: str) -> None:
        """Print, long lines wrapped at words."""
        width = max(shutil.get_terminal_size((100, 24)).columns - 1, 20)
        for line in visible(text).split("\n"):
            print(textwrap.fill(line, width) if len(line) > width else line, flush=True)

    def ask(self, prompt: str, tick: Callable[[], None]) -> str | None:
        """Return a line, None if none came in time; raises EOFError at the end of the input.

        tick is called twice a second while waiting.
        """
        tick_s = 0.5  # time between two calls of tick
        line, end_s, terminal = "", time.monotonic() + PATIENCE_S, sys.stdin.isatty()
        with system.single_keys() if terminal else nullcontext():
            print(visible(prompt), end="", flush=True)  # now keys can be read
            while True:
                key = self._reader(tick_s)
                if terminal and key in self.keys and not (key == " " and line):
                    shown = f"{prompt.lstrip()}{line}"[-40:]
                    print(f"\r\x1b[K  [{self.keys[key]()}] {shown}", end="", flush=True)
                    tick()  # reports a stopped robot at once
                elif key and key not in ("enter", "end"):
                    letter = key if len(key) == 1 and key.isprintable() else ""
                    edited = line[:-1] if key == "backspace" else line + letter
                    if terminal:  # a pipe needs no echo
                        erased = "\b \b" * (len(line) - len(edited))
                        print(erased or edited[len(line) :], end="", flush=True)
                    line = edited
                elif key or time.monotonic() > end_s:
                    print(flush=True)
                    if key == "end" and not line:
                        raise EOFError
                    return line.strip() if key else None
                else:
                    tick()

    def forget(self) -> None:
        """Drop what was typed ahead at a terminal; lines from a pipe are kept."""
        if sys.stdin.isatty():
            self._reader.forget()
            system.forget_input()
