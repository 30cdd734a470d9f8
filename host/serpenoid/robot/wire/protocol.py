"""Lines of the wire to messages and back (firmware/PROTOCOL.md); no input or output here."""

from __future__ import annotations

import binascii
import math
import re
from dataclasses import dataclass, field

from ..._core import firmware
from ...base.errors import BadInput, CommandRefused, DamagedLine
from .encoding import count_in

PROTOCOL: int = firmware.PROTOCOL
ERRORS = {word: tuple(row) for word, *row in firmware.ERRORS}  # number, what happened, what to do
FEWEST_JOINTS, MOST_JOINTS = 2, 12
LEAST_FRAME_US, MOST_FRAME_US = 3_000, 32_500  # time between frames
LONGEST_LINE = 400  # bytes, from a board of twelve joints and some to spare
STATES = ("idle", "pose", "gait", "hold", "safing", "safe")


def line_limit(joints: int) -> int:
    """Return the longest line to a board, in bytes before the line end."""
    return max(80, 20 + 12 * joints)


@dataclass(frozen=True, slots=True)
class Telemetry:
    """One frame: setpoints in rad (tail first), board time and pulses in µs, phase in rad.

    clipped: how many joints the board held back at a limit or at the servos' speed. sensor: the
    reading of a builder's own sensor, None where the firmware has none.
    """

    frame: int
    setpoint_rad: tuple[float, ...]
    board_us: int
    phase_rad: float
    pulse_us: tuple[int, ...]
    exec_us: int
    late_us: int
    clipped: int
    state: str
    sensor: int | None = None


@dataclass(frozen=True)
class Hello:
    """The board's greeting: who it is, how many joints it has, and which of its starts this is.

    settings: where they came from; silence_s: after how long without a line a robot in motion
    goes to its safe pose, 0 for never.
    """

    firmware: str
    protocol: int
    board: str
    joints: int
    frame_us: int
    boot: int
    reset: str
    settings: str
    silence_s: float = field(compare=False)  # it may change without a reset


@dataclass(frozen=True)
class Verdict:
    """The answer to a command; number is None for `#-`, `#!` and `#?`, kept in mark."""

    accepted: bool
    number: int | None
    mark: str
    error: str
    detail: str
    is_repeat: bool


@dataclass(frozen=True)
class Data:
    """Any other line: its word, and what follows the colon."""

    word: str
    text: str


Message = Telemetry | Hello | Verdict | Data


def crc(text: str) -> int:
    """Return the CRC-16/IBM-3740 of ASCII text."""
    return binascii.crc_hqx(text.encode("ascii"), 0xFFFF)


def seal(command: str, number: int, joints: int = 5) -> bytes:
    """Return the bytes of a numbered command; raise BadInput if the board could not read it."""
    if number not in range(1 << 16):
        raise BadInput(f"sequence number is {number}; it must be from 0 to 65535")
    if not (command and command.isascii() and command.isprintable()):
        raise BadInput(f"command is {command[:60]!r}; it must be printable ASCII and not empty")
    if "!" in command:
        raise BadInput(
            f"command is {command[:60]!r}; a ! stops the board wherever it stands: call stop"
        )
    body = f"#{number} {command}"
    line = f"{body} *{crc(body):04X}"
    if len(line) > (limit := line_limit(joints)):
        raise BadInput(f"the line has {len(line)} bytes; at most {limit}: shorten {command[:60]!r}")
    return line.encode("ascii") + b"\n"


def unseal(line: bytes) -> str:
    """Return the body of a line from the board; raise DamagedLine unless its CRC is right."""
    text = line.rstrip(b"\r\n")
    if len(text) > LONGEST_LINE:
        raise DamagedLine(f"{text[:40]!r}... has {len(text)} bytes; at most {LONGEST_LINE}")
    if not (text.isascii() and text.decode("ascii").isprintable()):
        raise DamagedLine(f"{line!r} has bytes that are not printable ASCII; check the baud rate")
    body, mark, digits = text.decode("ascii").rpartition(" *")
    if not mark or digits != f"{crc(body):04X}":
        raise DamagedLine(f"{line!r} has not the CRC of its bytes, {crc(body):04X}")
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


def _matched(pattern: str, body: str) -> tuple[str, ...]:
    match = re.fullmatch(pattern, body, re.ASCII)
    if not match:
        raise DamagedLine(f"{body!r} is not in the form of protocol {PROTOCOL}")
    return tuple(field or "" for field in match.groups())


def _telemetry(body: str) -> Telemetry:
    pattern = (
        r"t:(\d{1,10})((?: j\d{1,2}:-?\d{1,3}\.\d\d){2,12}) board_us=(\d{1,10})"
        r" ph=(\d{1,3}\.\d{3}) p=(\d{1,5}(?:,\d{1,5}){1,11}) exec_us=(\d{1,10})"
        r" late_us=(\d{1,10}) clipped=(\d{1,2}) st=([a-z]+)(?: sensor=(-?\d{1,5}))?"
    )
    frame, joints, board_us, phase, pulses, exec_us, late_us, clipped, state, sensor = _matched(
        pattern, body
    )
    if state not in STATES:
        raise DamagedLine(f"state is {state!r}; protocol {PROTOCOL} has {', '.join(STATES)}")
    labels, angles = zip(*(joint.split(":") for joint in joints.split()), strict=True)
    widths = tuple(int(x) for x in pulses.split(","))
    if labels != tuple(f"j{j}" for j in range(1, len(widths) + 1)) or int(clipped) > len(widths):
        raise DamagedLine(f"{body!r} does not count its joints from 1 to their number")
    return Telemetry(
        count_in("t", frame),
        tuple(math.radians(float(x)) for x in angles),
        count_in("board_us", board_us),
        math.radians(float(phase)),
        widths,
        count_in("exec_us", exec_us),
        count_in("late_us", late_us),
        int(clipped),
        state,
        int(sensor) if sensor else None,
    )


def _verdict(body: str) -> Verdict:
    kind, mark, text = _matched(r"(ok|err): #(\d{1,5}|[-!?])(?: ([a-z].*))?", body)
    words = text.split()
    error = words.pop(0) if kind == "err" and words else ""
    if (kind == "err") != bool(error):
        raise DamagedLine(f"{body!r} does not say why")
    is_repeat = words[:1] == ["again"]
    number = int(mark) if mark.isdigit() else None
    return Verdict(kind == "ok", number, mark, error, " ".join(words[is_repeat:]), is_repeat)


def refused(text: str, error: str, detail: str = "") -> CommandRefused:
    """Return the error that the board refused a command: its own detail, or else the table's."""
    if not detail and error in ERRORS:
        detail = "- {1}; {2}".format(*ERRORS[error])
    return CommandRefused(f"the board refuses {text!r}: {error} {detail}", error)


def _hello(body: str) -> Hello:
    pattern = (
        r"hello: serpenoid fw=(\S+) protocol=(\d{1,5}) board=(\S+) joints=(\d{1,2})"
        r" frame_us=(\d{1,5}) boot=(\d{1,5}) reset=(\S+) settings=(\S+)"
        r" silence=(off|\d{1,4}(?:\.\d{1,6})?)"
    )
    version, protocol, board, joints, frame_us, boot, reset, settings, silence = _matched(
        pattern, body
    )
    silence_s = 0.0 if silence == "off" else float(silence)
    return Hello(
        version,
        int(protocol),
        board,
        count_in("joints", joints, FEWEST_JOINTS, MOST_JOINTS),
        count_in("frame_us", frame_us, LEAST_FRAME_US, MOST_FRAME_US),
        int(boot),
        reset,
        settings,
        silence_s,
    )
