"""Any bytes to the whole controller: a verdict for each line, and joints that keep their limits."""

from __future__ import annotations

import binascii
import math
import re
from itertools import pairwise

from hypothesis import given, settings
from hypothesis import strategies as st
from serpenoid._core import firmware

Q14_RAD = 1 / 16384  # what a setpoint resolves
STEP_SLACK_RAD = 4 * Q14_RAD  # so that roundings are not told as clipping
FRAME_S = 0.02
SETTLE_S = 0.6  # longer than any report or save


def numbers(low: float, high: float) -> st.SearchStrategy[str]:
    """Return numbers as they are typed, now and then outside the limits."""
    inside = st.floats(low, high).map(lambda v: f"{v:.3f}".rstrip("0").rstrip("."))
    return inside | st.sampled_from([f"{low:g}", f"{high:g}", "0", "-1", "2147", "1e3", "x"])


def words(first: str, *fields: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
    return st.tuples(st.just(first), *fields).map(" ".join)


ANGLE = numbers(-90, 90) | numbers(-20, 15)
GAIT = [numbers(low, high) for _, low, high, _ in firmware.GAIT.values()]
MOTION = st.one_of(
    *(words("gait", *GAIT[:count]) for count in (3, 4)),
    *(words("pose", *fields) for fields in ([st.just("straight"), ANGLE], [ANGLE] * 5)),
)
FIELDS = [
    words("set", st.just(name), numbers(low, high))
    for name, (_, low, high, _) in firmware.SETTINGS.items()
]
FIELDS += [
    words("trim", st.sampled_from("12345"), st.just(name), numbers(low, high))
    for name, (_, low, high, _) in firmware.TRIM.items()
]
BARE = [
    *("hello", "bye", "ping", "help", "status", "stop", "!", "idle", "set", "trim", "save"),
    *("load", "defaults", "pose straight"),
]
BODY = st.one_of(MOTION, st.one_of(*FIELDS), st.sampled_from(BARE))


def sealed(body: bytes) -> bytes:
    return body + b" *%04X" % binascii.crc_hqx(body, 0xFFFF)


@st.composite
def lines(draw: st.DrawFn) -> bytes:
    """Return a line without its end: a person's, a host's, a damaged one, or noise."""
    body = draw(BODY).encode()
    kind = draw(st.sampled_from(["typed", "numbered", "damaged", "noise"]))
    if kind == "noise":
        return draw(st.binary(max_size=120))
    if kind == "typed":
        return body
    line = bytearray(sealed(b"#%d %b" % (draw(st.integers(0, 65536)), body)))
    if kind == "damaged":
        line[draw(st.integers(0, len(line) - 1))] ^= 1 << draw(st.integers(0, 7))
    return bytes(line)


def booted() -> firmware.Board:
    board = firmware.Board()
    board.boot()
    board.run(FRAME_S / 2)  # from here on, whole frames end half-way between two
    return board


def heard(board: firmware.Board) -> list[str]:
    """Return the bodies of the lines that came, every CRC checked."""
    found = board.read().decode("ascii").splitlines()
    for line in found:
        assert sealed(line[:-6].encode()) == line.encode()
    return [line[:-6] for line in found]


@settings(max_examples=150, deadline=None, derandomize=True)
@given(st.lists(lines(), max_size=25))
def test_every_line_has_one_verdict(sent: list[bytes]) -> None:
    board = booted()
    for line in sent:
        heard(board)
        board.write(line + b"\n")
        board.run(SETTLE_S)
        verdicts = [said for said in heard(board) if said.startswith(("ok: #", "err: #"))]
        assert verdicts.count("ok: #!") == line.count(b"!")
        whole = re.split(rb"[\r\n]", line + b"\n")
        ends = [part.rpartition(b"!")[2] for part in whole]  # a ! drops what stands before it
        # a line of noise that ends in `stop` has the stop's verdict beside its own
        beside = [e for e in ends if e.endswith(b"stop") and (len(e) > 80 or not e.isascii())]
        assert len(verdicts) == line.count(b"!") + len([e for e in ends if e]) + len(beside)


def limits(board: firmware.Board) -> tuple[float, list[tuple[float, float]]]:
    """Return servo speed (rad/s) and each joint's least and greatest angle (rad), as listed."""
    heard(board)
    board.write(b"set\ntrim\n")
    board.run(0.1)
    values = [dict(re.findall(r"(\w+)=(\S+)", said)) | {"_": said} for said in heard(board)]
    joints = [v for v in values if v["_"].startswith("trim: ")]
    speed = next(v for v in values if v["_"].startswith("set: servo_speed"))
    ranges = [tuple(math.radians(float(v[end])) for end in ("low", "high")) for v in joints]
    return math.radians(float(speed["value"])), ranges


# Limits that the motions of MOTION press against.
TIGHT = "set servo_speed 40\nset pose_speed 360\ntrim 2 low -20\ntrim 4 high 15\n"


@settings(max_examples=100, deadline=None, derandomize=True)
@given(
    st.sampled_from([TIGHT, ""]),
    st.lists(st.tuples(MOTION | BODY, st.sampled_from([2, 10, 40, 150])), min_size=3, max_size=20),
)
def test_no_joint_leaves_its_limits_or_exceeds_the_servos_speed(
    prologue: str, script: list[tuple[str, int]]
) -> None:
    board = booted()
    board.write(prologue.encode())
    board.run(SETTLE_S)
    speed, ranges = limits(board)
    for body, frames in script:
        board.write(f"{body}\n".encode())
        path = [board.setpoints_rad] if board.state != "idle" else []
        for _ in range(frames):
            board.run(FRAME_S)
            path += [board.setpoints_rad] if board.state != "idle" else []
        old_speed, (speed, ranges) = speed, limits(board)
        fastest = max(old_speed, speed) * FRAME_S + STEP_SLACK_RAD
        for before, now in pairwise(path):
            assert all(abs(b - a) <= fastest for a, b in zip(before, now, strict=True))
        for angles in path[1:]:
            for angle, (low, high) in zip(angles, ranges, strict=True):
                assert low - Q14_RAD <= angle <= high + Q14_RAD
