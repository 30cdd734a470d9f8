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


def one_frame(port: serial.Serial) -> tuple[float, float]:
    """Return the time on the wall and on the board, in s, at a frame that comes now."""
    port.reset_input_buffer()
    port.readline()
    frame = fields(await_line(port, b"t:"))
    return time.monotonic(), int(frame["board_us"]) * 1e-6


def test_it_keeps_real_time(simulated_board):
    """Never faster; slower only while a busy machine lets it be: not for a minute on end."""
    with serial.Serial(simulated_board.port, 250_000, timeout=0.5) as port:
        await_line(port, b"hello:")
        for _ in range(60):
            wall_s, board_s = one_frame(port)
            time.sleep(1.0)
            now_s, then_s = one_frame(port)
            ahead_s = (then_s - board_s) - (now_s - wall_s)
            assert ahead_s < 0.3  # it may make good 0.2 s
            if ahead_s > -0.1:
                break
        else:
            pytest.fail(f"it is {-ahead_s:.2f} s slow in one of ours")
