"""The firmware's controller behind a pseudo-terminal, in real time, with a wire that may be bad."""

from __future__ import annotations

import os
import pty
import select
import threading
import time
import tty
from collections.abc import Callable
from contextlib import suppress

from serpenoid._core import firmware


class PtyBoard:
    """Give `port` to open; `received` are the bytes that came. spoil: what the wire makes of bytes.

    Without a controller (silent=True) nothing ever answers.
    """

    def __init__(self, spoil: Callable[[bytes], bytes] = bytes, silent: bool = False):
        self.board = firmware.Board()
        self.board.boot("external")
        self.received = bytearray()
        self._spoil, self._silent = spoil, silent
        self._master, self._slave = pty.openpty()
        tty.setraw(self._slave)
        self.port = os.ttyname(self._slave)
        os.close(self._slave)
        self._end = threading.Event()
        self._thread = threading.Thread(target=self._serve, daemon=True)

    def __enter__(self) -> PtyBoard:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.unplug()

    def unplug(self) -> None:
        """Pull the cable."""
        self._end.set()
        self._thread.join(5)
        with suppress(OSError):
            os.close(self._master)

    def _serve(self) -> None:
        begun_s = time.monotonic() - self.board.time_s
        while not self._end.is_set():
            with suppress(OSError):  # nobody has it open
                if select.select([self._master], [], [], 0.005)[0]:
                    came = os.read(self._master, 4096)
                    self.received += came
                    self.board.write(came)
            self.board.run(max(time.monotonic() - begun_s - self.board.time_s, 0.0))
            said = self._spoil(self.board.read())
            if said and not self._silent:
                with suppress(OSError):
                    os.write(self._master, said)
            self._end.wait(0.002)
