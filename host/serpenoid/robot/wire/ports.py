"""The serial ports of this computer: which may be the robot, and who has them."""

from __future__ import annotations

import os
from dataclasses import asdict
from pathlib import Path
from typing import Any

from ...model.errors import PortBusy
from . import port_diagnosis
from .link import missing, serial_ports


def port_states() -> list[dict[str, Any]]:
    """List the serial ports, by name: whether this user may open each, and who has it open."""
    return [
        {
            "device": port.device,
            "description": port.description,
            "usb": f"{port.vendor_id:04x}:{port.product_id:04x}" if port.vendor_id else None,
            "likely_board": bool(port.chip),
            "chip": port.chip or None,
            "allowed": allowed(port.device),
            "held_by": [asdict(holder) for holder in port_diagnosis.who_holds(port.device)],
        }
        for port in serial_ports()
    ]


def allowed(device: str) -> bool:
    """Tell whether this user may open a port."""
    return os.access(device, os.R_OK | os.W_OK)


def users(device: str) -> list[port_diagnosis.Holder]:
    """List the programs that have a port open, but not those that simulate a board at it."""
    return [] if port_diagnosis.is_pseudo_terminal(device) else port_diagnosis.who_holds(device)


def check_free(device: str) -> None:
    """Raise PortMissing if there is no such port, PortBusy, naming who, if it is used."""
    if os.name == "posix" and not Path(device).is_char_device():
        raise missing(device)
    if holders := users(device):
        raise PortBusy(port_diagnosis.why_held(device, holders))
