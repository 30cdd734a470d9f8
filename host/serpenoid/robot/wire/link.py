"""Bytes to and from a board over the serial port. Only this file imports pyserial."""

from __future__ import annotations

import errno
import threading
import time
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from ...model import system
from ...model.errors import PortBusy, PortMissing, RobotLost
from . import port_diagnosis

if TYPE_CHECKING:
    import serial
    from serial.tools.list_ports_common import ListPortInfo

BAUD = 250_000
WRITE_TIMEOUT_S = 1.0
# USB vendors of these boards and of the serial chips on their copies.
BOARD_VENDORS = {0x2341: "Arduino", 0x2A03: "Arduino", 0x1A86: "CH340", 0x0403: "FTDI"}


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


def serial_ports() -> list[ListPortInfo]:
    """List the serial ports of this computer, by name; vid and pid are None unless it is USB."""
    from serial.tools.list_ports import comports

    return sorted(comports(), key=lambda port: port.device)


def board_chip(port: ListPortInfo) -> str | None:
    """Name the maker of a likely board's USB chip."""
    return BOARD_VENDORS.get(port.vid)


def find_port() -> str:
    """Return the one port with a likely board on it; raise PortMissing naming what is there."""
    boards = [p for p in serial_ports() if board_chip(p)]
    if len(boards) == 1:
        return boards[0].device
    if boards:
        names = ", ".join(f"{p.device} ({board_chip(p)}, {p.description})" for p in boards)
        raise PortMissing(f"{len(boards)} ports may be the robot: {names}; name one of them")
    raise PortMissing(
        f"no board found by its USB id; serial ports here: {port_names('none at all')}. "
        f"{port_diagnosis.why_no_port()}"
    )


def port_names(none: str = "none") -> str:
    """Return the serial ports of this computer in words; none: the word for none."""
    return ", ".join(p.device for p in serial_ports()) or none


def is_there(port: str) -> bool:
    """Tell whether there is such a port."""
    return any(p.device == port for p in serial_ports()) or Path(port).is_char_device()


def missing(port: str) -> PortMissing:
    """Return the error that there is no such port, naming those that there are."""
    return PortMissing(f"there is no port {port}; serial ports here: {port_names()}")


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

    # Asked first because the opening itself would reset a robot that another program is driving.
    if holders := port_diagnosis.users(port):
        raise PortBusy(port_diagnosis.why_held(port, holders))
    try:
        opened = serial.Serial(port, BAUD, exclusive=True, write_timeout=WRITE_TIMEOUT_S)
    except OSError as error:
        raise _refused(port, error) from error
    system.exclude_others(opened, True)  # pyserial's lock is heeded only by programs that lock too
    return opened


def _refused(port: str, error: OSError) -> PortBusy | PortMissing:
    said = str(error) if system.WINDOWS else ""  # there pyserial keeps no number
    if error.errno in (errno.EBUSY, errno.EAGAIN, errno.EWOULDBLOCK) or "PermissionError" in said:
        return PortBusy(port_diagnosis.why_held(port, port_diagnosis.who_holds(port)))
    if error.errno in (errno.EACCES, errno.EPERM):
        return PortBusy(port_diagnosis.why_forbidden(port))
    if error.errno in (errno.ENOENT, errno.ENODEV, errno.ENXIO) or "FileNotFoundError" in said:
        return missing(port)
    return PortMissing(
        f"{port} cannot be used as a serial port ({error}); those here: {port_names()}"
    )
