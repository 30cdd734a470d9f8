"""The simulated board behind a pseudo-terminal, as the host's programs meet it."""

import time

import pytest
import serial
from avr.dialogue import fields, unseal

pytestmark = pytest.mark.avr


def await_line(port: serial.Serial, word: bytes, timeout_s: float = 5.0) -> str:
    end = time.monotonic() + timeout_s
    while time.monotonic() < end:
        line = port.readline()
        if line.startswith(word):
            return unseal(line.decode().rstrip())
    raise AssertionError(f"no {word!r} within {timeout_s} s")


def test_open_reset_hang_and_unplug(simulated_board):
    with serial.Serial(simulated_board.port, 250_000, timeout=0.5) as port:
        opened = fields(await_line(port, b"hello:"))
        assert opened["reset"] == "external"
        port.write(b"ping\n")
        await_line(port, b"ok: #-")
        simulated_board.press_reset()
        pressed = fields(await_line(port, b"hello:"))
        assert int(pressed["boot"]) == int(opened["boot"]) + 1
        simulated_board.hang()
        assert fields(await_line(port, b"hello:"))["reset"] == "watchdog"
        simulated_board.unplug()
        with pytest.raises(serial.SerialException):
            port.read(1_000_000)


def test_it_keeps_real_time(simulated_board):
    with serial.Serial(simulated_board.port, 250_000, timeout=0.5) as port:
        await_line(port, b"hello:")
        first, begun = await_line(port, b"t:"), time.monotonic()
        time.sleep(2.0)
        port.reset_input_buffer()
        port.readline()
        last, ended = await_line(port, b"t:"), time.monotonic()
    board_s = (int(fields(last)["board_us"]) - int(fields(first)["board_us"])) * 1e-6
    # A loaded machine may wake the simulator late; a systematic error of pace would show in 2 s.
    assert board_s == pytest.approx(ended - begun, abs=0.25)
