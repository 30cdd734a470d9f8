"""The simulated board behind a pseudo-terminal, as the host's programs meet it."""

import time

import pytest
import serial
from avr.dialogue import fields, unseal

pytestmark = pytest.mark.avr


def await_line(port: serial.Serial, word: bytes, most_s: float = 60.0) -> str:
    end = time.monotonic() + most_s
    while time.monotonic() < end:
        line = port.readline()
        if line.startswith(word):
            return unseal(line.decode().rstrip())
    raise AssertionError(f"no {word!r} within {most_s} s")


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
