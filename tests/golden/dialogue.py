"""Read dialogue.txt, and hold a board to it: each line in turn, nothing else said."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from pathlib import Path

PATH = Path(__file__).with_name("dialogue.txt")
# What depends on the board's clock is passed over, but for the lines that the dialogue lists.
TIMED = ("t:", "status:", "timing:")
PATIENCE_S = 10.0
STEP_S = 0.005


def steps() -> Iterator[tuple[str, bytes]]:
    """Yield (mark, bytes): `>` to the board, `<` a line from it without line end, `~` seconds."""
    for line in PATH.read_text().splitlines():
        if line[:2] in ("> ", "< ", "~ "):
            one_byte = re.compile(r"\\n|\\x([0-9A-F]{2})")
            text = one_byte.sub(lambda m: chr(int(m[1], 16)) if m[1] else "\n", line[2:])
            yield line[0], text.encode("latin-1")


def play(
    write: Callable[[bytes], object],
    run: Callable[[float], object],
    take: Callable[[], bytes],
    *,
    timed: bool,
    renamed: Callable[[bytes], bytes] = bytes,
) -> int:
    """Speak the host's part; assert that the board says the rest; return how many lines it said.

    timed: the board's clock is exact, so that the listed telemetry must come as it stands.
    renamed: makes of a line of dialogue.txt what this board says instead.
    """
    received = bytearray()
    count = 0
    for mark, text in steps():
        if mark == ">":
            assert not _next(received, b""), f"unasked for, before {text!r}"
            write(text)
        elif mark == "~":
            run(float(text))
            received += take()
        elif timed or not text.startswith(b"t:"):
            _await(renamed(text), received, run, take)
            count += 1
    run(1.0)
    received += take()
    assert not _next(received, b""), "more than the dialogue has"
    return count


def _next(received: bytearray, expected: bytes) -> bytes:
    """Take the next whole line that is to be compared, or return nothing."""
    while b"\n" in received:
        line, _, remainder = bytes(received).partition(b"\n")
        received[:] = remainder
        if line == expected or not line.startswith(tuple(word.encode() for word in TIMED)):
            return line
    return b""


def _await(
    expected: bytes, received: bytearray, run: Callable[[float], object], take: Callable[[], bytes]
) -> None:
    for _ in range(int(PATIENCE_S / STEP_S)):
        line = _next(received, expected)
        if line:
            assert line == expected, f"{line!r} instead of {expected!r}"
            return
        run(STEP_S)
        received += take()
    raise AssertionError(f"{expected!r} did not come within {PATIENCE_S} s")
