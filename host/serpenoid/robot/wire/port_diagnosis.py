"""Find what keeps a serial port from being opened, as far as the system shows it, and the cure."""

from __future__ import annotations

import os
from dataclasses import dataclass

from ...model import system

MOST_NAMED = 3
PRIVILEGED = ("root", "wheel", "admin", "sudo", "shadow", "disk")
CH340 = "1a86"  # its USB vendor
BRLTTY = (
    "brltty, the driver for Braille displays, takes boards with a CH340 for one of them: "
    "remove it with `sudo apt remove brltty` unless you need it, then plug the board in again"
)
MODEM_MANAGER = (
    "ModemManager asks every new port whether it is a modem: wait half a minute, or end it "
    "with `sudo systemctl stop ModemManager`"
)
MEDDLERS = {"brltty": BRLTTY, "ModemManager": MODEM_MANAGER}  # programs that take ports, the cure


@dataclass(frozen=True)
class Holder:
    """A program that has the port open."""

    pid: int
    name: str


def who_holds(port: str) -> list[Holder]:
    """List the programs that have a port open; of other users' programs only root sees that."""
    return [Holder(pid, name) for pid, name in system.holders(port).items()]


def users(port: str) -> list[Holder]:
    """List the programs that have a port open, but not those that simulate a board at it."""
    return [] if system.is_pseudo_terminal(port) else who_holds(port)


def running(name: str) -> bool:
    """Tell whether a program of that name runs here."""
    return name in system.programs().values()


def why_held(port: str, holders: list[Holder]) -> str:
    """Say who has the port and how to get it back."""
    if not holders:
        suspects = [cure for name, cure in MEDDLERS.items() if running(name)]
        advice = suspects[0] if suspects else "close serial monitors, plotters and other scripts"
        return f"{port} is taken by a program that this user may not see; {advice}"
    who = ", ".join(f"{h.name} (process {h.pid})" for h in holders[:MOST_NAMED])
    who += f" and {len(holders) - MOST_NAMED} more" if len(holders) > MOST_NAMED else ""
    cures = [MEDDLERS[h.name] for h in holders if h.name in MEDDLERS]
    if holders[0].pid == os.getpid():
        cures = ["this very program has it open: leave its other `with Robot` first"]
    return f"{port} is in use by {who}; {cures[0] if cures else 'close it there first'}"


def why_forbidden(port: str) -> str:
    """Say which group may open the port and how to join it."""
    group = system.group_of(port) or "dialout"
    if group in PRIVILEGED:  # to join these would give away the whole computer
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
    if running("brltty"):
        return BRLTTY[0].upper() + BRLTTY[1:]
    if CH340 in system.usb_vendors():
        return (
            "A CH340 is plugged in but has no port: its driver ch341 is missing, or brltty took it"
        )
    driver = "; a copy with a CH340 needs its maker's driver" if system.WINDOWS else ""
    return f"Plug the board in (with a cable that carries data), or name its port{driver}"
