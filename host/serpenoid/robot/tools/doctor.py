"""Find what keeps a robot from working, and say the fix; nothing here moves it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

from ...base.checks import check_number
from ...base.errors import NoAnswer, PortBusy, ProtocolMismatch, RobotError
from ..robot import RobotBoard
from ..wire import ports
from ..wire.protocol import PROTOCOL, Hello
from .limp_test import RELEASED
from .upload import find_platformio

Mark = Literal["ok", "note", "fix"]


@dataclass(frozen=True)
class Finding:
    """One thing looked at: what was found, and what to do unless mark is "ok".

    mark "note" is worth knowing and keeps nothing from working; "fix" is to be put right.
    """

    name: str
    mark: Mark
    found: str
    fix: str = ""

    @classmethod
    def judged(cls, name: str, result: str, is_well: bool, fix: str) -> Finding:
        """Return what is "ok", or to be put right by a fix."""
        return cls(name, "ok", result) if is_well else cls(name, "fix", result, fix)


def examine(
    port: str | None = None, listen_s: float = 3.0, timeout_s: float = 5.0
) -> Iterator[Finding]:
    """Look at one thing after another, as far as what was found allows; None finds the port.

    listen_s: how long to count frames, at least 0.2; timeout_s: how long to wait for a greeting.
    """
    check_number("listen_s", listen_s, 0.2, 600.0)
    try:
        yield from _robot(port, listen_s, timeout_s)
    except RobotError as error:
        troubles = {  # what an error is about, and what was found
            PortBusy: ("other programs", "in use"),
            NoAnswer: ("greeting", "none"),
            ProtocolMismatch: ("protocol", "another one"),
        }
        name, result = troubles.get(type(error), ("port", "not usable"))
        yield Finding(name, "fix", result, str(error))
    if pio := find_platformio():
        yield Finding("platformio", "ok", pio)
    else:
        fix = "needed for flashing only: pip install platformio"
        yield Finding("platformio", "note", "not installed", fix)


def _robot(port: str | None, listen_s: float, timeout_s: float) -> Iterator[Finding]:
    """Look whether the port is there, and who may open it, then at the board."""
    if port is not None and port.startswith("virtual"):
        yield Finding("port", "ok", f"{port}: the firmware in this process, no robot")
    else:
        port = port or ports.find_port()
        if not ports.is_there(port):
            raise ports.missing(port)
        yield Finding("port", "ok", port)
        may_open = ports.allowed(port)
        yield Finding.judged("permission", f"to open {port}", may_open, ports.why_forbidden(port))
        if not may_open:
            return
    with RobotBoard(port, timeout_s=timeout_s) as robot:
        yield Finding("greeting", "ok", f"{robot.hello.board}, boot {robot.hello.boot}")
        yield Finding("protocol", "ok", f"{PROTOCOL}, firmware {robot.hello.firmware}")
        yield from _settings(robot.hello, robot.settings())
        yield from _running(robot, listen_s)


def _settings(hello: Hello, settings: dict[str, float]) -> Iterator[Finding]:
    anew = "check each servo and save: serpenoid trim"
    copies: dict[str, tuple[Mark, str, str]] = {
        "ok": ("ok", "whole", ""),
        "new": (
            "note",
            "nothing saved yet: the firmware's defaults are in use",
            "centre the servos: serpenoid trim",
        ),
        "older": ("fix", "the newest copy was damaged, the one before it is in use", anew),
        "damaged": ("fix", "both copies are damaged: the firmware's defaults are in use", anew),
    }
    yield Finding("settings", *copies.get(hello.settings, ("fix", hello.settings, anew)))
    if not settings["silence"]:
        fix = "send `set silence 2` and `save`: serpenoid monitor"
        yield Finding("silence", "note", "off: nothing stops the robot if the host dies", fix)
    released = settings["released"]
    mark: Mark = "ok" if released == 1.0 else "note"
    fix = "" if released else "try it once, one servo unlinked: serpenoid doctor --limp"
    yield Finding("without pulses", mark, RELEASED.get(released, f"code {released:g}"), fix)
    resets = {
        "brownout": "give the servos a supply of their own and join the grounds",
        "watchdog": "the program hung: flash the newest firmware; if it persists, report it",
    }
    if hello.reset in resets:
        yield Finding("last reset", "fix", hello.reset, resets[hello.reset])


def _running(robot: RobotBoard, listen_s: float) -> Iterator[Finding]:
    """Listen for a while, then judge losses, timing and clock."""
    robot.set("every", 1)  # until the next reset, so that there is something to hear
    frames = sum(1 for _ in robot.frames(listen_s))
    status = robot.status()
    counts = {name: getattr(status, name) for name in ("damaged", "lost", "rxfull")}
    counts |= {name: getattr(robot.losses, name) for name in ("damaged_lines", "missed_frames")}
    losses = ", ".join(f"{name} {count}" for name, count in counts.items() if count)
    cure = "use a shorter or better USB cable, and no hub; without any frame, serpenoid flash"
    result = losses or f"clean, over {frames} frames"
    yield Finding.judged("counters", result, bool(frames) and not losses, cure)
    result = (
        f"{status.overruns} frames missed, latest frame {status.late_us} us late, "
        f"longest pass {status.longest_pass_us} us"
    )
    cure = "flash the newest firmware: serpenoid flash; if it persists, report these numbers"
    max_late_us = 2000  # the firmware's own budget for a frame (firmware/README.md)
    in_time = not status.overruns and status.late_us <= max_late_us
    yield Finding.judged("timing", result, in_time, cure)
    drift = robot.clock
    if not drift.span_s:
        yield Finding("clock", "note", "not measured", "listen longer: --listen-s 5")
        return
    result = f"{drift.ppm:+.0f} ± {drift.sd_ppm:.0f} ppm against this computer"
    cure = "beyond any resonator: is the right board flashed?"
    yield Finding.judged("clock", result, drift.believable, cure)
