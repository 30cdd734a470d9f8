"""The serial ports of this computer: which may be the robot, and who has them."""

from __future__ import annotations

import os
from dataclasses import asdict
from typing import Any

from ...model import system
from ...model.errors import PortBusy
from . import port_diagnosis
from .link import board_chip, is_there, missing, serial_ports


def port_states() -> list[dict[str, Any]]:
    """List the serial ports, by name: whether this user may open each, and who has it open."""
    return [
        {
            "device": port.device,
            "description": port.description or "",
            "usb": f"{port.vid:04x}:{port.pid:04x}" if port.vid else None,
            "likely_board": board_chip(port) is not None,
            "chip": board_chip(port),
            "allowed": allowed(port.device),
            "held_by": [asdict(holder) for holder in port_diagnosis.who_holds(port.device)],
        }
        for port in serial_ports()
    ]


def allowed(device: str) -> bool:
    """Tell whether this user may open a port."""
    return system.WINDOWS or os.access(device, os.R_OK | os.W_OK)


def check_free(device: str) -> None:
    """Raise PortMissing if there is no such port, PortBusy, naming who, if it is used."""
    if not is_there(device):
        raise missing(device)
    if holders := port_diagnosis.users(device):
        raise PortBusy(port_diagnosis.why_held(device, holders))
