"""Read and write bytes of a board; the only module that opens serial ports."""

from __future__ import annotations

import errno
import threading
import time
from typing import TYPE_CHECKING, Protocol

from ...base import system
from ...base.errors import PortBusy, PortMissing, RobotLost
from .ports import find_port, missing, port_names, why_forbidden, why_held

if TYPE_CHECKING:
    import serial

BAUD = 250_000  # Baud rate of the firmware, bit/s.


class Link(Protocol):
    """A connection to a board, real or virtual; its errors are RobotError.

    lockstep: whether time passes only in read(), so that a caller never waits.
    """

    name: str
    lockstep: bool

    def now_s(self) -> float:
        """Return the time by the host's clock for this link, s, from an arbitrary start."""
        ...

    def read(self, timeout_s: float) -> bytes:
        """Return the bytes that came within timeout_s; raises RobotLost if the link broke."""
        ...

    def write(self, data: bytes) -> None:
        """Send all bytes; may be called from any thread and from a signal handler."""
        ...

    def close(self) -> None:
        """Close the port; a second call does nothing."""
        ...


def open_link(port: str | Link | None) -> Link:
    """Return a link to a port, or to a virtual board; None finds the board by its USB id.

    An open link is returned as it is. Raises BadInput, and PortMissing or PortBusy with the likely
    cause and what to do.
    """
    if not (port is None or isinstance(port, str)):
        return port
    if port is not None and port.partition(":")[0] == "virtual":
        from .virtual import virtual_link

        return virtual_link(port)
    return SerialLink(port or find_port())


class SerialLink:
    """A board on a serial port that no other program may open. Opening resets most boards."""

    lockstep = False

    def __init__(self, port: str):
        self.name = port
        self._port = _open(port)
        self._writing = threading.RLock()  # A signal handler may interrupt a write and write too.

    def now_s(self) -> float:
        """Return the time of the monotonic clock, s, which is disciplined but never jumps."""
        return time.monotonic()

    def read(self, timeout_s: float) -> bytes:
        """Return the received bytes after waiting up to timeout_s for the first one."""
        try:
            if timeout_s != self._port.timeout:  # Each change sets the baud rate anew.
                self._port.timeout = timeout_s
            first = self._port.read(1)
            return first + self._port.read(self._port.in_waiting) if first else b""
        except OSError as error:  # The errors of pyserial are OSErrors.
            raise self._lost(error) from error

    def write(self, data: bytes) -> None:
        """Send all bytes; raises RobotLost."""
        try:
            with self._writing:
                self._port.write(data)
        except OSError as error:
            raise self._lost(error) from error

    def close(self) -> None:
        """Close the port, which other programs may then open."""
        if self._port.is_open:
            system.exclude_others(self._port, False)
        self._port.close()

    def _lost(self, error: OSError) -> RobotLost:
        return RobotLost(
            f"{self.name} went away ({error}); the board stops by itself within its silence time: "
            "check the cable and the board's power, then start again"
        )


def _open(port: str) -> serial.Serial:
    import serial

    try:
        opened = serial.Serial(port, BAUD, exclusive=True, write_timeout=1.0)
    except OSError as error:
        raise _refused(port, error) from error
    system.exclude_others(opened, True)  # Only programs that lock too respect pyserial's lock.
    return opened


def _refused(port: str, error: OSError) -> PortBusy | PortMissing:
    text = str(error) if system.WINDOWS else ""  # On Windows pyserial keeps no error number.
    if error.errno in (errno.EBUSY, errno.EAGAIN, errno.EWOULDBLOCK) or "PermissionError" in text:
        return PortBusy(why_held(port, error))
    if error.errno in (errno.EACCES, errno.EPERM):
        return PortBusy(why_forbidden(port))
    if error.errno in (errno.ENOENT, errno.ENODEV, errno.ENXIO) or "FileNotFoundError" in text:
        return missing(port)
    return PortMissing(
        f"{port} cannot be used as a serial port ({error}); those here: {port_names()}"
    )
