"""Lines of the wire to messages and back (firmware/PROTOCOL.md); no input or output here."""

from __future__ import annotations

import binascii
import math
import re
from dataclasses import dataclass

from ...model.errors import BadInput, DamagedLine
from .written import check_frame

PROTOCOL = 1
LINE_LIMIT = 80  # bytes to the board, before the line end
STATES = ("idle", "pose", "gait", "hold", "safing", "safe")
_ANGLE, _PULSE, _COUNT = r"(-?\d{1,3}\.\d\d)", r"(\d{1,5})", r"(\d{1,10})"
_TELEMETRY = re.compile(
    rf"t:{_COUNT}" + "".join(rf" j{j}:{_ANGLE}" for j in range(1, 6)) + rf" us={_COUNT}"
    r" ph=(\d{1,3}\.\d{3}) p=" + ",".join([_PULSE] * 5) + rf" ex={_COUNT} la={_COUNT} st=([a-z]+)",
    re.ASCII,
)
_VERDICT = re.compile(r"(ok|err): #(\d{1,5}|[-!?])(?: ([a-z].*))?", re.ASCII)
_HELLO = re.compile(
    r"hello: serpenoid fw=(\S+) protocol=(\d{1,5}) board=(\S+) boot=(\d{1,5}) reset=(\S+)"
    r" settings=(\S+)",
    re.ASCII,
)


@dataclass(frozen=True)
class Telemetry:
    """One frame: setpoints in rad (tail first), board time and pulses in µs, phase in rad."""

    frame: int
    setpoint_rad: tuple[float, ...]
    board_us: int
    phase_rad: float
    pulse_us: tuple[int, ...]
    exec_us: int
    late_us: int
    state: str


@dataclass(frozen=True)
class Hello:
    """The board's greeting: who it is, and which of its starts this is."""

    firmware: str
    protocol: int
    board: str
    boot: int
    reset: str
    settings: str


@dataclass(frozen=True)
class Verdict:
    """The answer to a command; number is None for `#-`, `#!` and `#?`, kept in mark."""

    accepted: bool
    number: int | None
    mark: str
    error: str
    detail: str
    again: bool


@dataclass(frozen=True)
class Data:
    """Any other line: its word, and what follows the colon."""

    word: str
    text: str


Message = Telemetry | Hello | Verdict | Data


def crc(text: str) -> int:
    """Return the CRC-16/IBM-3740 of ASCII text."""
    return binascii.crc_hqx(text.encode("ascii"), 0xFFFF)


def seal(command: str, number: int) -> bytes:
    """Return the bytes of a numbered command; raise BadInput if the board could not read it."""
    if not 0 <= number <= 0xFFFF:
        raise BadInput(f"sequence number is {number}; it must be from 0 to 65535")
    if not command or not all(" " <= c <= "~" for c in command):
        raise BadInput(f"command is {command!r}; it must be printable ASCII and not empty")
    body = f"#{number} {command}"
    line = f"{body} *{crc(body):04X}"
    if len(line) > LINE_LIMIT:
        raise BadInput(f"the line has {len(line)} bytes; at most {LINE_LIMIT}: shorten {command!r}")
    return line.encode("ascii") + b"\n"


def unseal(line: bytes) -> str:
    """Return the body of a line from the board; raise DamagedLine unless its CRC is right."""
    text = line.rstrip(b"\r\n")
    if not all(0x20 <= b <= 0x7E for b in text):
        raise DamagedLine(f"{line!r} has bytes that are not printable ASCII; check the baud rate")
    body, mark, digits = text.decode("ascii").rpartition(" *")
    if not mark or not re.fullmatch(r"[0-9A-F]{4}", digits):
        raise DamagedLine(f"{line!r} has no CRC; it was cut, or is not from this firmware")
    if crc(body) != int(digits, 16):
        raise DamagedLine(f"{line!r} has CRC {digits}; its bytes give {crc(body):04X}")
    return body


def parse(line: bytes) -> Message:
    """Return the message in a line from the board; raise DamagedLine if it is none."""
    body = unseal(line)
    word, colon, text = body.partition(":")
    if not colon or not re.fullmatch(r"[a-z]+", word):
        raise DamagedLine(f"{body!r} does not start with a word and a colon")
    if word == "t":
        return _telemetry(body)
    if word in ("ok", "err"):
        return _verdict(body)
    return _hello(body) if word == "hello" else Data(word, text.strip())


def _matched(pattern: re.Pattern[str], body: str) -> tuple[str, ...]:
    found = pattern.fullmatch(body)
    if not found:
        raise DamagedLine(f"{body!r} is not in the form of protocol {PROTOCOL}")
    return tuple(field or "" for field in found.groups())


def _telemetry(body: str) -> Telemetry:
    f = _matched(_TELEMETRY, body)
    if f[15] not in STATES:
        raise DamagedLine(f"state is {f[15]!r}; protocol {PROTOCOL} has {', '.join(STATES)}")
    for name, value in zip(("t", "us", "ex", "la"), (f[0], f[6], f[13], f[14]), strict=True):
        if int(value) >= 1 << 32:
            raise DamagedLine(f"{name} is {value}; the board counts it in 32 bits")
    setpoints = tuple(math.radians(float(x)) for x in f[1:6])
    pulses = tuple(int(x) for x in f[8:13])
    phase_rad = math.radians(float(f[7]))
    check_frame(setpoints, pulses, phase_rad)
    return Telemetry(
        int(f[0]), setpoints, int(f[6]), phase_rad, pulses, int(f[13]), int(f[14]), f[15]
    )


def _verdict(body: str) -> Verdict:
    kind, mark, rest = _matched(_VERDICT, body)
    words = rest.split()
    error = words.pop(0) if kind == "err" and words else ""
    if (kind == "err") != bool(error):
        raise DamagedLine(f"{body!r} does not say why")
    again = words[:1] == ["again"]
    number = int(mark) if mark.isdigit() else None
    return Verdict(kind == "ok", number, mark, error, " ".join(words[again:]), again)


def _hello(body: str) -> Hello:
    firmware, protocol, board, boot, reset, settings = _matched(_HELLO, body)
    return Hello(firmware, int(protocol), board, int(boot), reset, settings)
