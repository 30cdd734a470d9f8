"""Read keys as they are pressed; the terminal is always restored."""

from __future__ import annotations

import codecs
import re
import sys

from ...base import system
from ...base.errors import BadInput

ARROWS = {"C": "right", "D": "left"}
NAMES = {
    "\n": "enter",
    "\r": "enter",
    "\x7f": "backspace",
    "\x08": "backspace",
    "\x04": "end",
}


def need_terminal() -> None:
    """Raise BadInput unless standard input is a terminal."""
    if sys.stdin is None or not sys.stdin.isatty():  # it may be closed
        raise BadInput("standard input is no terminal; this command is for a person's keys")


class KeyReader:
    """Bytes of standard input to keys; several may come at once, one may come in pieces.

    A key is one character, a name of ARROWS or NAMES, or "other"; "end" is the end of the input.
    """

    def __init__(self) -> None:
        self._text = ""
        self._decoder = codecs.getincrementaldecoder("utf-8")("replace")

    def forget(self) -> None:
        """Drop what was typed ahead."""
        self._text = ""

    def __call__(self, timeout_s: float) -> str:
        """Return the next key within so many seconds, or nothing."""
        if not self._text:
            self._fill(timeout_s)
        # The rest of a key's code comes within 0.05 s.
        while re.search(r"\x1b(\[[\d;]*|O)?$", self._text) and self._fill(0.05):
            pass
        # A key is one character, or a code behind an escape: of an arrow, of Delete, of F1.
        key = re.match(r"\x1b(\[[\d;]*[A-Za-z~]|O[A-Z])|.", self._text, re.DOTALL)
        if not key:
            return ""
        self._text = self._text[key.end() :]
        if key[1]:
            return ARROWS.get(key[1][-1], "other")
        return NAMES.get(key[0], key[0])

    def _fill(self, timeout_s: float) -> bool:
        data = system.read_input(timeout_s)
        if data is not None:
            self._text += self._decoder.decode(data) if data else "\x04"
        return bool(data)
