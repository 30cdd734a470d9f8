"""The whole controller through its Python binding: what any bytes must leave true."""

from __future__ import annotations

import binascii
import itertools

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from serpenoid._core import firmware

COMMANDS = [
    "gait 30 80 5",
    "gait 60 -75 4 10",
    "pose straight 20",
    "pose straight",
    "ping",
    "status",
]


def sealed(body: str) -> bytes:
    return f"{body} *{binascii.crc_hqx(body.encode(), 0xFFFF):04X}\n".encode()


def booted() -> firmware.Board:
    board = firmware.Board()
    board.boot()
    return board


def check_lines(data: bytes) -> list[str]:
    lines = data.decode("ascii").split("\n")[:-1]
    for line in lines:
        body, _, crc = line.rpartition(" *")
        assert int(crc, 16) == binascii.crc_hqx(body.encode(), 0xFFFF)
    return lines


@settings(max_examples=100, deadline=None, derandomize=True)
@given(st.lists(st.one_of(st.binary(max_size=90), st.sampled_from([c.encode() for c in COMMANDS]))))
def test_whatever_comes_every_line_out_is_whole_and_a_stop_stops(parts: list[bytes]) -> None:
    board = booted()
    for part in parts:
        board.write(part + b"\n")
        board.run(0.05)
    board.write(b"\n!\n")
    board.run(0.2)
    assert board.state in ("hold", "idle")
    held = board.setpoints_rad
    board.run(1.0)
    assert board.setpoints_rad == held
    check_lines(board.read())


@settings(max_examples=60, deadline=None, derandomize=True)
@given(
    st.lists(st.sampled_from(COMMANDS), min_size=1, max_size=30), st.randoms(use_true_random=False)
)
def test_in_a_session_every_good_line_has_one_verdict_and_no_bad_one_is_obeyed(
    bodies: list[str], random
) -> None:
    board = booted()
    board.write(sealed("#0 hello"))
    board.run(0.1)
    board.read()
    good, bad, number = 0, 0, itertools.count(1)
    for body in bodies:
        if random.random() < 0.3:  # one flipped bit, not into a line end
            line = bytearray(sealed(f"#9999 {body}")[:-1])
            line[random.randrange(len(line))] ^= 1 << random.randrange(7)
            if b"\n" in line or b"\r" in line or b"!" in line:
                continue
            board.write(bytes(line) + b"\n")
            bad += 1
        else:
            board.write(sealed(f"#{next(number)} {body}"))
            good += 1
        board.run(0.1)
    lines = check_lines(board.read())
    assert sum(line.startswith("ok: #") for line in lines) == good
    assert sum(line.startswith("err: #?") for line in lines) == bad
    assert board.counters["lost"] == board.counters["repeated"] == 0


def test_the_tables_of_the_protocol_page_are_the_boards(request: pytest.FixtureRequest) -> None:
    page = (request.config.rootpath / "firmware" / "PROTOCOL.md").read_text()
    for word, number, cause, cure in firmware.ERRORS:
        assert f"| `{word}` | {number} | {cause} | {cure} |" in page
    for name, (_, low, high, default) in {**firmware.SETTINGS, **firmware.TRIM}.items():
        row = next(line for line in page.splitlines() if line.startswith(f"| `{name}` |"))
        for value in (low, high, default):
            assert f"{value:g}".replace("-", "−") in row
    assert f"fw={firmware.VERSION} protocol={firmware.PROTOCOL} " in page


def test_a_board_that_was_not_booted_says_so() -> None:
    with pytest.raises(RuntimeError, match="has not been booted"):
        firmware.Board().run(1.0)
