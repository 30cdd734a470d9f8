"""Bytes to and from a board over the serial port. Only this file opens one."""

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

BAUD = 250_000


class Link(Protocol):
    """What a Robot needs of a wire, real or virtual; its errors are RobotError."""

    name: str
    lockstep: bool  # time passes only in read(), so that there is nothing to wait for

    def now_s(self) -> float:
        """Return the host's clock for this wire, in seconds from an arbitrary start."""
        ...

    def read(self, timeout_s: float) -> bytes:
        """Return what has come, after at most timeout_s; raise RobotLost if the wire broke."""
        ...

    def write(self, data: bytes) -> None:
        """Send all bytes; callable from any thread and from a signal handler."""
        ...

    def close(self) -> None:
        """Give the port back; harmless when done twice."""
        ...


def open_link(port: str | Link | None) -> Link:
    """Open a port by name, or a virtual board; None finds the board by its USB id.

    A link is taken as it is. Raises PortMissing or PortBusy, which name the likely cause and its
    cure; BadInput.
    """
    if not (port is None or isinstance(port, str)):
        return port
    if port is not None and port.partition(":")[0] == "virtual":
        from .virtual import virtual_link

        return virtual_link(port)
    return SerialLink(port or find_port())


class SerialLink:
    """A board on a serial port, taken for this program alone; opening resets most boards."""

    lockstep = False

    def __init__(self, port: str):
        self.name = port
        self._port = _open(port)
        self._writing = threading.RLock()  # a signal handler may write amid a write

    def now_s(self) -> float:
        """Return the monotonic clock, which follows the network's time but never jumps."""
        return time.monotonic()

    def read(self, timeout_s: float) -> bytes:
        """Return the bytes that have come, waiting up to timeout_s for the first."""
        try:
            if timeout_s != self._port.timeout:  # each setting sets the baud rate anew
                self._port.timeout = timeout_s
            first = self._port.read(1)
            return first + self._port.read(self._port.in_waiting) if first else b""
        except OSError as error:  # pyserial's own error is one
            raise self._lost(error) from error

    def write(self, data: bytes) -> None:
        """Send all bytes, or raise RobotLost."""
        try:
            with self._writing:
                self._port.write(data)
        except OSError as error:
            raise self._lost(error) from error

    def close(self) -> None:
        """Give the port back."""
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
    system.exclude_others(opened, True)  # pyserial's lock is heeded only by programs that lock too
    return opened


def _refused(port: str, error: OSError) -> PortBusy | PortMissing:
    text = str(error) if system.WINDOWS else ""  # there pyserial keeps no number
    if error.errno in (errno.EBUSY, errno.EAGAIN, errno.EWOULDBLOCK) or "PermissionError" in text:
        return PortBusy(why_held(port, error))
    if error.errno in (errno.EACCES, errno.EPERM):
        return PortBusy(why_forbidden(port))
    if error.errno in (errno.ENOENT, errno.ENODEV, errno.ENXIO) or "FileNotFoundError" in text:
        return missing(port)
    return PortMissing(
        f"{port} cannot be used as a serial port ({error}); those here: {port_names()}"
    )
