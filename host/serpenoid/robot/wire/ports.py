"""The serial ports of this computer: which may be the robot, what bars them, and the cure."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...base import system
from ...base.errors import PortMissing

if TYPE_CHECKING:
    from serial.tools.list_ports_common import ListPortInfo


def serial_ports() -> list[ListPortInfo]:
    """List the serial ports of this computer, by name; vid and pid are None unless it is USB."""
    from serial.tools.list_ports import comports

    return sorted(comports(), key=lambda port: port.device)


def board_chip(port: ListPortInfo) -> str | None:
    """Name the maker of a likely board's USB chip."""
    # USB vendors of the boards and of the serial chips on their copies.
    makers = {0x2341: "Arduino", 0x2A03: "Arduino", 0x1A86: "CH340", 0x0403: "FTDI"}
    return makers.get(port.vid)


def find_port() -> str:
    """Return the one port with a likely board on it; raise PortMissing naming what is there."""
    boards = [p for p in serial_ports() if board_chip(p)]
    if len(boards) == 1:
        return boards[0].device
    if boards:
        names = ", ".join(f"{p.device} ({board_chip(p)}, {p.description})" for p in boards)
        raise PortMissing(f"{len(boards)} ports may be the robot: {names}; name one of them")
    raise PortMissing(
        f"no board found by its USB id; serial ports here: {port_names()}. {why_no_port()}"
    )


def port_names() -> str:
    """Return the serial ports of this computer in words."""
    return ", ".join(p.device for p in serial_ports()) or "none"


def is_there(port: str) -> bool:
    """Tell whether there is such a port."""
    return any(p.device == port for p in serial_ports()) or Path(port).is_char_device()


def missing(port: str) -> PortMissing:
    """Return the error that there is no such port, naming those that there are."""
    return PortMissing(f"there is no port {port}; serial ports here: {port_names()}")


def port_states() -> list[dict[str, Any]]:
    """List the serial ports, by name: what each is, and whether this user may open it."""
    return [
        {
            "device": port.device,
            "description": port.description or "",
            "usb": f"{port.vid:04x}:{port.pid:04x}" if port.vid else None,
            "chip": board_chip(port),
            "allowed": allowed(port.device),
        }
        for port in serial_ports()
    ]


def allowed(device: str) -> bool:
    """Tell whether this user may open a port."""
    return system.WINDOWS or os.access(device, os.R_OK | os.W_OK)


def why_held(port: str, error: object) -> str:
    """Say that another program has the port, as the system told, and how to get it back."""
    return (
        f"{port} is in use by another program ({error}): close serial monitors, plotters and other "
        "scripts; ModemManager asks every new port for half a minute whether it is a modem: wait, "
        "or end it with `sudo systemctl stop ModemManager`"
    )


def why_forbidden(port: str) -> str:
    """Say which group may open the port and how to join it."""
    group = system.group_of(port) or "dialout"
    # Joining one of these would give away the whole computer.
    if group in ("root", "wheel", "admin", "sudo", "shadow", "disk"):
        return (
            f"this user may not open {port}, which belongs to {group} alone: give the port to "
            'dialout with a udev rule (KERNEL=="ttyACM*", GROUP="dialout"), join that group '
            "(`sudo usermod -aG dialout $USER`), plug the board in again and log in again"
        )
    return (
        f"this user may not open {port}, which belongs to the group {group}: "
        f"`sudo usermod -aG {group} $USER`, then log out and in again"
    )


def why_no_port() -> str:
    """Say why a board that is plugged in may have no port."""
    if "1a86" in system.usb_vendors():  # vendor of the CH340
        return (
            "A CH340 is plugged in but has no port: its driver ch341 is missing, or brltty, the "
            "driver for Braille displays, takes boards with a CH340 for one of them: remove it "
            "with `sudo apt remove brltty` unless you need it, then plug the board in again"
        )
    driver = "; a copy with a CH340 needs its maker's driver" if system.WINDOWS else ""
    return f"Plug the board in (with a cable that carries data), or name its port{driver}"
