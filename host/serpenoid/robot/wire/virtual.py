"""A virtual robot: the firmware's own controller in this process, behind a Link."""

from __future__ import annotations

import re
import threading
import time

from ...base.errors import BadInput
from .protocol import FEWEST_JOINTS, MOST_JOINTS

STEP_S = 0.002  # step of the board's time, within which a fast board answers
LEAST_S = 40e-6  # a byte on the wire, the board's own step: less would not pass at all


def virtual_link(port: str) -> VirtualLink:
    """Open `virtual`, with any of `:fast` and `:joints=N` behind it; raise BadInput."""
    named = re.fullmatch(r"virtual(?::fast|:joints=(\d{1,2}))*", port, re.ASCII)
    joints = int((named and named[1]) or 5)
    if not named or not FEWEST_JOINTS <= joints <= MOST_JOINTS:
        raise BadInput(
            f"port is {port!r}; a virtual board is `virtual`, `virtual:fast`, `virtual:joints=9` "
            "or `virtual:fast:joints=9`, with 2 to 12 joints"
        )
    return VirtualLink(fast=":fast" in port, joints=joints)


class VirtualLink:
    """A wire to the firmware's controller, at the pace of the clock or as fast as it goes.

    The controller, its wire of 250000 baud and its EEPROM (empty at first) are those of
    serpenoid._core.firmware.Board, kept as `board`. fast: its time passes only in read(), so
    that a run takes as long as it computes and is the same every time. joints: 2 to 12.
    """

    def __init__(self, *, fast: bool = False, joints: int = 5):
        from ..._core import firmware

        self.lockstep = fast
        self.name = "virtual:fast" if fast else "virtual"
        self.board = firmware.Board(joints=joints)
        self.board.boot("external")
        self._begun_s = time.monotonic()
        self._using = threading.RLock()  # a signal handler may write amid a read

    def now_s(self) -> float:
        """Return the board's time if fast, else the monotonic clock."""
        return self.board.time_s if self.lockstep else time.monotonic()

    def read(self, timeout_s: float) -> bytes:
        """Let time pass, up to timeout_s, and return what the board said in it."""
        if self.lockstep:
            with self._using:
                self.board.run(max(LEAST_S, min(timeout_s, STEP_S)))
                return self.board.read()
        end_s = time.monotonic() + timeout_s
        while not (data := self._catch_up()) and time.monotonic() < end_s:
            time.sleep(0.005)
        return data

    def write(self, data: bytes) -> None:
        """Put bytes on the wire to the board."""
        with self._using:
            self.board.write(data)

    def close(self) -> None:
        """Do nothing: there is no port to give back."""

    def _catch_up(self) -> bytes:
        with self._using:
            behind_s = time.monotonic() - self._begun_s - self.board.time_s
            self.board.run(max(behind_s, 0.0))
            return self.board.read()
