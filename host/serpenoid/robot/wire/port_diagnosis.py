"""Find what keeps a serial port from being opened, as far as Linux shows it, and the cure."""

from __future__ import annotations

import os
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

PROC = Path("/proc")
PSEUDO_TERMINALS = range(136, 144)  # Linux's device numbers
MOST_NAMED = 3
PRIVILEGED = ("root", "wheel", "admin", "sudo", "shadow", "disk")
USB = Path("/sys/bus/usb/devices")
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
    device = _device(port)
    return [Holder(pid, _name(pid)) for pid in _pids() if device and device in _open(pid)]


def users(port: str) -> list[Holder]:
    """List the programs that have a port open, but not those that simulate a board at it."""
    return [] if is_pseudo_terminal(port) else who_holds(port)


def is_pseudo_terminal(port: str) -> bool:
    """Tell whether a program plays the board at this port, and may well hold it open itself."""
    return os.major(_device(port)) in PSEUDO_TERMINALS


def running(name: str) -> bool:
    """Tell whether a program of that name runs here."""
    return any(_name(pid) == name for pid in _pids())


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
    group = "dialout"
    with suppress(ImportError, OSError, KeyError):
        import grp

        group = grp.getgrgid(os.stat(port).st_gid).gr_name
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
    if _ch340_plugged_in():
        return (
            "A CH340 is plugged in but has no port: its driver ch341 is missing, or brltty took it"
        )
    return "Plug the board in (with a cable that carries data), or name its port"


def _pids() -> list[int]:
    with suppress(OSError):
        return sorted(int(p) for p in os.listdir(PROC) if p.isdigit())
    return []


def _name(pid: int) -> str:
    return _word(PROC / str(pid) / "comm") or "a program"


def _open(pid: int) -> list[int]:
    folder = PROC / str(pid) / "fd"
    with suppress(OSError):
        return [_device(folder / fd) for fd in os.listdir(folder)]
    return []


def _ch340_plugged_in() -> bool:
    return any(_word(vendor) == "1a86" for vendor in USB.glob("*/idVendor"))


def _device(path: str | Path) -> int:
    """Return a device's number; 0 for what is no device or is gone."""
    with suppress(OSError):
        return os.stat(path).st_rdev
    return 0


def _word(path: Path) -> str:
    """Return what the system tells in a file of one word; nothing if it is gone."""
    with suppress(OSError):
        return path.read_text().strip()
    return ""
