"""Boards that misbehave as told, in lockstep or behind a pseudo-terminal: the tampered firmware."""

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

from avr.dialogue import sealed
from robot.patience import LONG_S, clock, until
from serpenoid import Gait
from serpenoid._core import firmware
from serpenoid.base.errors import RobotLost
from serpenoid.robot.wire.virtual import VirtualLink

Tamper = Callable[[bytes], bytes]
GAIT = Gait(alpha_rad=math.radians(30), beta_rad=math.radians(80), omega_rad_s=5.0)
GAIT_TYPED = "--alpha-deg 30 --beta-deg 80 --omega-rad-s 5"
MOST_AT_ONCE_S = 0.02  # that the board runs before its host may speak again


def honest(line: bytes) -> bytes:
    return line


def nothing(_: bytes) -> bytes:
    return b""


def without(*words: str) -> Tamper:
    """Return a tamper that loses the lines which start with one of the words."""
    return lambda line: b"" if line.startswith(tuple(w.encode() for w in words)) else line


def resealed(line: bytes, pattern: bytes, by: bytes) -> bytes:
    """Return a line with its body changed and its CRC right again."""
    body = line.rpartition(b" *")[0]
    changed = re.sub(pattern, by, body)
    return line if changed == body else sealed(changed.decode())


def greeting(pattern: bytes, by: bytes) -> Tamper:
    """Return a tamper that changes what the board greets with."""
    return lambda line: resealed(line, pattern, by) if line.startswith(b"hello:") else line


def eeprom_after(*commands: str) -> bytes:
    """Return the EEPROM of a board that was given commands, then `save unattended`."""
    board = firmware.Board()
    board.boot()
    board.write("".join(f"{command}\n" for command in (*commands, "save unattended")).encode())
    board.run(2.0)
    return board.eeprom


class FastBoard(VirtualLink):
    """A virtual board in lockstep, which a Robot takes for its port: 2 s of patience pass at once.

    Every line passes through to_host or to_board first, as in FakeBoard; opening resets nothing.
    """

    def __init__(self, to_host: Tamper = honest, to_board: Tamper = honest):
        super().__init__(fast=True)
        self.to_host, self.to_board = to_host, to_board
        self.received, self._rest, self._unplugged = b"", b"", False

    @property
    def state(self) -> str:
        return self.board.state

    def reset(self, cause: str) -> None:
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


class FakeBoard:
    """Run the controller in real time; every line passes through to_host or to_board first.

    Both may be exchanged at any time; they get one line with its end and return any bytes.
    Opening the port starts the board again, as the reset of a real one does. pace: the clock it
    goes by; a host in another process knows the wall's alone.
    """

    def __init__(
        self,
        to_host: Tamper = honest,
        to_board: Tamper = honest,
        *,
        eeprom: bytes | None = None,
        pace: Callable[[], float] = clock,
    ):
        self.to_host, self.to_board = to_host, to_board
        self._pace = pace
        self.board = firmware.Board()
        self.board.eeprom = eeprom or self.board.eeprom
        self.received = b""
        self._master, slave = pty.openpty()
        tty.setraw(slave)
        self.port = os.ttyname(slave)
        os.close(slave)  # so that POLLHUP tells whether a host has it open
        self._open = self._unplugged = False
        self._rest = {"host": b"", "board": b""}
        self._using = threading.RLock()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def __enter__(self) -> FakeBoard:
        return self

    def __exit__(self, *_: object) -> None:
        self.unplug()

    @property
    def state(self) -> str:
        return self.board.state

    def reset(self, cause: str) -> None:
        with self._using:
            self.board.boot(cause)

    def unplug(self) -> None:
        """Pull the cable; it is out on return, but where a tamper pulls it: then soon."""
        self._unplugged = True
        if threading.current_thread() is not self._thread:
            self._thread.join(LONG_S)

    def await_state(self, state: str, most_s: float = LONG_S) -> bool:
        return until(lambda: self.state == state, most_s)

    def goes_on(self, seconds: float) -> None:
        """Wait while so much of the board's time passes."""
        end_s = self.board.time_s + seconds
        assert until(lambda: self.board.time_s >= end_s)

    def _run(self) -> None:
        self.board.boot("power")
        poll = select.poll()
        poll.register(self._master, select.POLLIN)
        run_s = self._pace()
        while not self._unplugged:
            self._serve(poll.poll(0))
            step_s = min(self._pace() - run_s, MOST_AT_ONCE_S)
            run_s += step_s
            with self._using:
                self.board.run(step_s)
                said = self.board.read()
            if self._open:
                self._pass_on("host", said, self.to_host, self._send)
            time.sleep(0.002)
        os.close(self._master)

    def _serve(self, events: list[tuple[int, int]]) -> None:
        state = events[0][1] if events else 0
        if not state & select.POLLHUP and not self._open:
            self.reset("external")
        self._open = not state & select.POLLHUP
        if state & select.POLLIN:
            data = os.read(self._master, 4096)
            self.received += data
            self._pass_on("board", data, self.to_board, self.board.write)

    def _pass_on(
        self, end: str, data: bytes, tamper: Tamper, send: Callable[[bytes], None]
    ) -> None:
        *lines, self._rest[end] = (self._rest[end] + data).split(b"\n")
        for line in lines:
            if changed := tamper(line + b"\n"):
                send(changed)

    def _send(self, data: bytes) -> None:
        os.write(self._master, data)
