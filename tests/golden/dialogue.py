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
    heard = bytearray()
    said = 0
    for mark, text in steps():
        if mark == ">":
            assert not _next(heard, b""), f"unasked for, before {text!r}"
            write(text)
        elif mark == "~":
            run(float(text))
            heard += take()
        elif timed or not text.startswith(b"t:"):
            _await(renamed(text), heard, run, take)
            said += 1
    run(1.0)
    heard += take()
    assert not _next(heard, b""), "more than the dialogue has"
    return said


def _next(heard: bytearray, wanted: bytes) -> bytes:
    """Take the next whole line that is to be compared, or return nothing."""
    while b"\n" in heard:
        line, _, rest = bytes(heard).partition(b"\n")
        heard[:] = rest
        if line == wanted or not line.startswith(tuple(word.encode() for word in TIMED)):
            return line
    return b""


def _await(
    wanted: bytes, heard: bytearray, run: Callable[[float], object], take: Callable[[], bytes]
) -> None:
    for _ in range(int(PATIENCE_S / STEP_S)):
        line = _next(heard, wanted)
        if line:
            assert line == wanted, f"{line!r} instead of {wanted!r}"
            return
        run(STEP_S)
        heard += take()
    raise AssertionError(f"{wanted!r} did not come within {PATIENCE_S} s")
