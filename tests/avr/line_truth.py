"""What a board must answer to any bytes at all: the wire's rules, written once more, slowly."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable

from avr.dialogue import crc

LONGEST = 80
SEALED = re.compile(rb"(.*) \*([0-9A-F]{4})", re.DOTALL)
NUMBERED = re.compile(rb"#([0-9]{1,5}) +(.*)", re.DOTALL)


class LineTruth:
    """The line layer of firmware/PROTOCOL.md inside a session that `hello` opened with a number.

    obey: what the command layer says to the body of a good line, `ok` or `err WORD`.
    """

    def __init__(self, number: int, obey: Callable[[str], str]):
        self.number, self.obey = number, obey
        self.verdicts: list[str] = []
        self.obeyed: list[str] = []
        self.counts: Counter[str] = Counter()
        self._last = ""
        self._line = b""

    def feed(self, data: bytes) -> None:
        """Take bytes as they arrive on the wire."""
        for value in data:
            if value == ord("!"):
                self.verdicts.append("ok: #!")
                self._line = b""
            elif value not in b"\r\n":
                self._line += bytes([value])
            elif self._line:
                line, self._line = self._line, b""
                self._take(line)

    def _refuse(self, number: str, word: str) -> None:
        self.counts[word] += 1
        self.verdicts.append(f"err: {number} {word}")

    def _take(self, line: bytes) -> None:
        if not all(0x20 <= value <= 0x7E for value in line):
            self._refuse("#?", "garbled")
        elif len(line) > LONGEST:
            self._refuse("#?", "overlong")
        elif line.endswith(b"stop"):
            self.verdicts.append("ok: #-")
        elif not (sealed := SEALED.fullmatch(line)):
            self._refuse("#?", "nocrc")
        elif f"{crc(sealed[1]):04X}".encode() != sealed[2]:
            self._refuse("#?", "crc")
        else:
            self._number(sealed[1])

    def _number(self, body: bytes) -> None:
        numbered = NUMBERED.fullmatch(body)
        if not numbered or int(numbered[1]) > 65535:
            self._refuse("#?", "sequence")
            return
        number, command = int(numbered[1]), numbered[2].decode()
        ahead = (number - self.number) % 65536
        if ahead == 0:
            self.counts["repeated"] += 1
            self.verdicts.append(f"{self._last} again")
        elif ahead >= 32768:
            self.counts["repeated"] += 1
            self.verdicts.append(f"err: #{number} sequence")
        else:
            self.counts["lost"] += ahead - 1
            self.number = number
            self.counts["good"] += 1
            self.obeyed.append(command)
            word, *error = self.obey(command).split()
            self._last = " ".join([f"{word}:", f"#{number}", *error])
            self.verdicts.append(self._last)
