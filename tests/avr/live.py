"""Run the firmware on a simulated board behind a pseudo-terminal, in real time, as a port."""

from __future__ import annotations

import contextlib
import os
import pty
import select
import threading
import time
import tty
from pathlib import Path

from avr.board import Board

SLICE_S = 0.002
MOST_BEHIND_S = 0.2  # a machine that stalled for longer goes on from now, without a burst


class LiveBoard:
    """A board on a port: `port` opens with pyserial (which resets it), but knows no DTR or RTS.

    boot_s: how long the boot loader keeps the program from running after each reset.
    """

    def __init__(self, elf: Path, *, boot_s: float = 0.0, reset_on_open: bool = True):
        self._board, self._boot_s, self._reset_on_open = Board(elf), boot_s, reset_on_open
        self._master, client = pty.openpty()
        tty.setraw(client)
        self.port = os.ttyname(client)
        os.close(client)  # so that the master is told whether a client has it open
        os.set_blocking(self._master, False)
        self._open = self._reset_pressed = self._unplugged = False
        self._held_until_s = 0.0
        self._serving = threading.Thread(target=self._serve, daemon=True)
        self._serving.start()

    def __enter__(self) -> LiveBoard:
        return self

    def __exit__(self, *_: object) -> None:
        self.unplug()

    def press_reset(self) -> None:
        """Press the reset button: the program starts again, the port stays open."""
        self._reset_pressed = True

    def hang(self) -> None:
        """Make the main program loop for ever; the watchdog has to notice."""
        self._board.hang()

    def unplug(self) -> None:
        """Pull the cable: the port goes away, whoever has it open sees it closed."""
        if not self._unplugged:
            self._unplugged = True
            self._serving.join()
            os.close(self._master)
            self._board.close()

    def _serve(self) -> None:
        due_s = time.monotonic()
        while not self._unplugged and self._board.runs:
            self._hear()
            if self._reset_pressed:
                self._reset_pressed = False
                self._board.reset()
                self._held_until_s = time.monotonic() + self._boot_s
            if time.monotonic() >= self._held_until_s:
                self._board.run(SLICE_S)
            self._say()
            due_s = max(due_s + SLICE_S, time.monotonic() - MOST_BEHIND_S)
            time.sleep(max(0.0, due_s - time.monotonic()))

    def _hear(self) -> None:
        poll = select.poll()
        poll.register(self._master, select.POLLIN)
        events = dict(poll.poll(0)).get(self._master, 0)
        was_open, self._open = self._open, not events & select.POLLHUP
        self._reset_pressed |= self._reset_on_open and self._open and not was_open
        if events & select.POLLIN:
            typed = os.read(self._master, 256)
            if time.monotonic() >= self._held_until_s:
                self._board.send(typed)

    def _say(self) -> None:
        said = self._board.read()
        if said and self._open:
            with contextlib.suppress(BlockingIOError):  # as a USB chip whose host does not read
                os.write(self._master, said)
