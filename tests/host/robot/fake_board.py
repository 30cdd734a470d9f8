"""Virtual boards whose lines a test may change or lose, in lockstep or at a pseudo-terminal."""

from __future__ import annotations

import math
import os
import pty
import re
import select
import threading
import time
import tty
from collections.abc import Callable
from contextlib import suppress

from avr.dialogue import sealed
from robot.patience import LONG_S, clock, until
from serpenoid import Gait
from serpenoid._core import firmware
from serpenoid.base.errors import RobotLost
from serpenoid.robot.wire.virtual import VirtualLink

# Gets one line with its end and returns the bytes that arrive in its place.
Tamper = Callable[[bytes], bytes]
GAIT = Gait(alpha_rad=math.radians(30), beta_rad=math.radians(80), omega_rad_s=5.0)
GAIT_TYPED = "--alpha-deg 30 --beta-deg 80 --omega-rad-s 5"
MAX_STEP_S = 0.02  # the board runs for at most this time before it reads again


def keep_line(line: bytes) -> bytes:
    return line


def drop_line(_: bytes) -> bytes:
    return b""


def drop_lines(*words: str) -> Tamper:
    """Return a tamper that removes the lines which start with one of the words."""
    return lambda line: b"" if line.startswith(tuple(w.encode() for w in words)) else line


def change_body(line: bytes, pattern: bytes, new: bytes) -> bytes:
    """Return a line with a change in its body, and with the CRC of the changed line."""
    body = line.rpartition(b" *")[0]
    changed = re.sub(pattern, new, body)
    return line if changed == body else sealed(changed.decode())


def change_greeting(pattern: bytes, new: bytes) -> Tamper:
    """Return a tamper that changes the board's answer to `hello`."""
    return lambda line: change_body(line, pattern, new) if line.startswith(b"hello:") else line


def eeprom_after(*commands: str) -> bytes:
    """Return the EEPROM of a board after some commands and `save unattended`."""
    board = firmware.Board()
    board.boot()
    board.write("".join(f"{command}\n" for command in (*commands, "save unattended")).encode())
    board.run(2.0)
    return board.eeprom


class FastBoard(VirtualLink):
    """A virtual board in lockstep, usable as the port of a RobotBoard: waiting takes no real time.

    Every line first passes through to_host or to_board, which a test may replace at any time. The
    board is not reset when the port is opened.
    """

    def __init__(
        self, to_host: Tamper = keep_line, to_board: Tamper = keep_line, *, fast: bool = True
    ):
        super().__init__(fast=fast)
        self.to_host, self.to_board = to_host, to_board
        self.received, self._rest, self._unplugged = b"", b"", False

    @property
    def state(self) -> str:
        return self.board.state

    def reset(self, cause: str) -> None:
        with self._using:
            self.board.boot(cause)

    def unplug(self) -> None:
        self._unplugged = True

    def read(self, timeout_s: float) -> bytes:
        self._check()
        *lines, self._rest = (self._rest + super().read(timeout_s)).split(b"\n")
        return b"".join([self.to_host(line + b"\n") for line in lines])

    def write(self, data: bytes) -> None:
        self._check()
        self.received += data
        for line in data.splitlines(keepends=True):
            super().write(self.to_board(line))

    def _check(self) -> None:
        if self._unplugged:
            raise RobotLost("the port went away")


class FakeBoard(FastBoard):
    """The same board in real time, at a pseudo-terminal.

    Opening the port resets the board, as with a real one. pace: the clock that the board follows;
    it must be time.monotonic if the host runs in another process.
    """

    def __init__(
        self,
        to_host: Tamper = keep_line,
        to_board: Tamper = keep_line,
        *,
        eeprom: bytes | None = None,
        pace: Callable[[], float] = clock,
    ):
        super().__init__(to_host, to_board, fast=False)
        self._pace, self._run_s = pace, pace()
        self.board.eeprom = eeprom or self.board.eeprom
        self.board.boot("power")
        self._master, slave = pty.openpty()
        tty.setraw(slave)
        self.port = os.ttyname(slave)
        os.close(slave)  # then POLLHUP is set while no host has the port open
        self._partial_line = b""
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def __enter__(self) -> FakeBoard:
        return self

    def __exit__(self, *_: object) -> None:
        self.unplug()

    def unplug(self) -> None:
        """Pull the cable. It is out on return, or soon after it if a tamper calls this."""
        super().unplug()
        if threading.current_thread() is not self._thread:
            self._thread.join(LONG_S)

    def await_state(self, state: str, most_s: float = LONG_S) -> bool:
        return until(lambda: self.state == state, most_s)

    def wait_in_board_time(self, seconds: float) -> None:
        """Wait until this time has passed on the board's clock."""
        end_s = self.board.time_s + seconds
        assert until(lambda: self.board.time_s >= end_s)

    def _catch_up(self) -> bytes:
        step_s = min(self._pace() - self._run_s, MAX_STEP_S)
        self._run_s += step_s
        with self._using:
            self.board.run(step_s)
            return self.board.read()

    def _run(self) -> None:
        poll = select.poll()
        poll.register(self._master, select.POLLIN)
        is_open = False
        with suppress(RobotLost):
            while True:
                state = dict(poll.poll(0)).get(self._master, 0)
                if not (state & select.POLLHUP or is_open):
                    self.reset("external")
                is_open = not state & select.POLLHUP
                if state & select.POLLIN:
                    lines, end, self._partial_line = (
                        self._partial_line + os.read(self._master, 4096)
                    ).rpartition(b"\n")
                    self.write(lines + end)
                output = self.read(0.0)
                if is_open and output:
                    os.write(self._master, output)
                time.sleep(0.002)
        os.close(self._master)
