"""A board behind a pseudo-terminal that misbehaves as told: the firmware's controller, tampered."""

from __future__ import annotations

import os
import pty
import select
import threading
import time
import tty
from collections.abc import Callable

from serpenoid._core import firmware
from serpenoid.robot.wire import protocol

Tamper = Callable[[bytes], bytes]


def sealed(body: str) -> bytes:
    return f"{body} *{protocol.crc(body):04X}\n".encode()


def honest(line: bytes) -> bytes:
    return line


def nothing(_: bytes) -> bytes:
    return b""


def eeprom_after(*commands: str) -> bytes:
    """Return the EEPROM of a board that was given commands, then `save unattended`."""
    board = firmware.Board()
    board.boot()
    board.write("".join(f"{command}\n" for command in (*commands, "save unattended")).encode())
    board.run(2.0)
    return board.eeprom


class FakeBoard:
    """Run the controller in real time; every line passes through to_host or to_board first.

    Both may be exchanged at any time; they get one line with its end and return any bytes.
    Opening the port starts the board again, as the reset of a real one does.
    """

    def __init__(
        self, to_host: Tamper = honest, to_board: Tamper = honest, *, eeprom: bytes | None = None
    ):
        self.to_host, self.to_board = to_host, to_board
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
        self._thread.join(5.0)

    @property
    def state(self) -> str:
        return self.board.state

    def reset(self, cause: str) -> None:
        with self._using:
            self.board.boot(cause)

    def unplug(self) -> None:
        self._unplugged = True

    def await_state(self, state: str, timeout_s: float = 3.0) -> bool:
        end_s = time.monotonic() + timeout_s
        while self.state != state and time.monotonic() < end_s:
            time.sleep(0.005)
        return self.state == state

    def _run(self) -> None:
        self.board.boot("power")
        poll = select.poll()
        poll.register(self._master, select.POLLIN)
        last_s = time.monotonic()
        while not self._unplugged:
            self._serve(poll.poll(0))
            now_s = time.monotonic()
            with self._using:
                self.board.run(now_s - last_s)
                said = self.board.read()
            if self._open:
                self._pass_on("host", said, self.to_host, self._send)
            last_s = now_s
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
