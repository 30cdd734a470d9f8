"""The serial ports of this computer: which may be the robot, and who has them."""

from __future__ import annotations

import os
from dataclasses import asdict, dataclass
from pathlib import Path

from ...model.errors import PortBusy
from . import port_diagnosis
from .link import SerialPort, missing, serial_ports


@dataclass(frozen=True)
class PortState(SerialPort):
    """One port, whether this user may open it, and who has it open."""

    allowed: bool
    held_by: tuple[port_diagnosis.Holder, ...]

    @property
    def usb(self) -> str:
        """Return the USB id as `lsusb` writes it, or nothing."""
        return f"{self.vendor_id:04x}:{self.product_id:04x}" if self.vendor_id else ""

    def to_dict(self) -> dict[str, object]:
        """Return plain values."""
        return {
            "device": self.device,
            "description": self.description,
            "usb": self.usb or None,
            "likely_board": bool(self.chip),
            "chip": self.chip or None,
            "allowed": self.allowed,
            "held_by": [asdict(holder) for holder in self.held_by],
        }


def port_states() -> list[PortState]:
    """List the serial ports, by name."""
    return [
        PortState(
            **vars(port),
            allowed=allowed(port.device),
            held_by=tuple(port_diagnosis.who_holds(port.device)),
        )
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
