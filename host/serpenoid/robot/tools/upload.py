"""Build the firmware with PlatformIO, put it on a board, and wait until the board greets."""

from __future__ import annotations

import os
import re
import shutil
import sys
from collections.abc import Callable
from importlib.metadata import version
from itertools import product
from pathlib import Path

from ... import _core
from ...base import system
from ...base.errors import BadInput, FlashFailed
from ..robot import RobotBoard
from ..signals import SignalGuard
from ..wire.ports import find_port, is_there, missing, serial_ports
from ..wire.protocol import FEWEST_JOINTS, Hello

# The Servo library makes 12 pulses with one timer, and the memory of an Uno or Nano holds 8 joints.
MAX_JOINTS = {"uno": 8, "nano": 8, "nano_old": 8, "mega": 12}
GREETING_S = 10.0
UPLOADING = "Uploading "  # how PlatformIO announces it, once everything is built
# What PlatformIO printed, what it means, what to do; the first row that fits counts.
CAUSES = (
    (
        r"HTTPClientError|InternetConnection|Max retries|Could not resolve host",
        "PlatformIO could not download its compiler",
        "connect to the internet once and try again",
    ),
    (
        r"not in sync|stk500|timeout communicating|protocol error",
        "the board's boot loader does not answer",
        "check --board and --port; a Nano with the old boot loader needs a newer one burnt",
    ),
    (
        r"[Ee]xpected signature|[Ii]nvalid device signature|[Dd]ouble check chip",
        "the board has another chip",
        "give the --board that it is",
    ),
    (
        r"can't open device|Permission denied|Resource busy",
        "the port could not be opened",
        "ask `serpenoid doctor`",
    ),
    (UPLOADING, "the upload failed", "check --board, --port and the cable, then try again"),
    (r"", "the firmware did not compile", "see above; what was changed in {project}?"),
)


def flash(
    board: str | None,
    port: str | None,
    show: Callable[[str], None],
    *,
    joints: int = 5,
    output: str = "servo",
) -> Hello:
    """Build, upload, and return the greeting of the new firmware.

    board: one of MAX_JOINTS, or None if the USB id tells; port: None finds it by USB id. show takes
    PlatformIO's output as it comes. output: "servo" or "pca9685", what makes the servos' pulses.
    Raises BadInput, PortMissing, PortBusy, FlashFailed, NoAnswer.
    """
    folder = find_project()
    pio = find_platformio()
    if not pio:
        raise FlashFailed("PlatformIO is not installed: `pip install platformio`")
    if port is not None and port.startswith("virtual"):
        raise BadInput(f"port is {port!r}, which has no flash memory; name a serial port")
    port = port or find_port()
    board = board or board_at(port)
    if not FEWEST_JOINTS <= joints <= MAX_JOINTS[board]:
        limits = f"the {board} takes {FEWEST_JOINTS} to {MAX_JOINTS[board]}, a mega up to 12"
        raise BadInput(f"joints is {joints}; {limits}")
    if not is_there(port):
        raise missing(port)
    command = [pio, "run", "-d", str(folder), "-e", board, "-t", "upload", "--upload-port", port]
    status, printed = _run(command, show, build_flags(joints, output))
    if status:
        cause, cure = next(words for pattern, *words in CAUSES if re.search(pattern, printed))
        raise FlashFailed(f"{cause} (pio exited {status}); {cure.format(project=folder)}")
    with RobotBoard(port, timeout_s=GREETING_S) as robot:
        hello = robot.hello
    if hello.joints != joints:
        raise FlashFailed(
            f"the board greets with {hello.joints} joints, built were {joints}: was another board "
            "flashed? check --port"
        )
    return hello


def build_flags(joints: int, output: str) -> str:
    """Return what PlatformIO is to add to the compiler's flags, the user's own before it."""
    flags = os.environ.get("PLATFORMIO_BUILD_FLAGS", "")
    pulses = "-D SERPENOID_PCA9685" if output == "pca9685" else ""
    return " ".join(f"{flags} -D SERPENOID_JOINTS={joints} {pulses}".split())


def find_platformio() -> str | None:
    """Return the path of `pio`: on PATH, or beside this Python; None if there is none."""
    return shutil.which("pio") or shutil.which(str(Path(sys.executable).with_name("pio")))


def find_project() -> Path:
    """Return the folder that holds platformio.ini and firmware/, from here up; raise BadInput."""
    folder = Path.cwd()
    for place in (folder, *folder.parents, Path(__file__).resolve().parents[4]):
        if (place / "platformio.ini").exists() and (place / "firmware" / "src").is_dir():
            return place
    if installed := installed_project():
        return installed
    raise BadInput(f"no firmware in {folder} or above it; run this in the folder of the source")


def installed_project() -> Path | None:
    """Return a copy of the firmware that came with the package, where PlatformIO may build it."""
    installed = Path(_core.__file__).parent / "board"
    if not (installed / "platformio.ini").exists():
        return None
    cache = Path(os.environ.get("XDG_CACHE_HOME") or "~/.cache").expanduser()
    place = cache / "serpenoid" / f"board-{version('serpenoid')}"
    if (place / "firmware").exists():  # maybe of another day, with files that are gone now
        shutil.rmtree(place / "firmware")
    shutil.copytree(installed, place, dirs_exist_ok=True)
    return place


def board_at(port: str) -> str:
    """Identify the board by its USB id. Raises BadInput."""
    # Vendor and product ids of boards that say what they are; copies have their chip's ids.
    usb_ids = {
        "uno": {(0x2A03, 0x43)} | {(0x2341, code) for code in (0x1, 0x43, 0x6A, 0x243)},
        "mega": set(product((0x2341, 0x2A03), (0x10, 0x42, 0x210, 0x242))),
    }
    place = os.path.realpath(port)
    ids = {(p.vid, p.pid) for p in serial_ports() if os.path.realpath(p.device) == place}
    for board, of_board in usb_ids.items():
        if ids & of_board:
            return board
    raise BadInput(
        f"the USB id of {port} does not tell the board; give --board {'|'.join(MAX_JOINTS)}"
    )


def _run(command: list[str], show: Callable[[str], None], flags: str) -> tuple[int, str]:
    """Run a program, showing what it prints as it comes; return its exit status and all of that.

    It gets a process group of its own, so that Ctrl-C reaches it through here alone, once.
    """
    printed = bytearray()
    guard = SignalGuard(lambda: None)  # SIGTERM and SIGHUP end it in order, too
    with system.start_group(command, {**os.environ, "PLATFORMIO_BUILD_FLAGS": flags}) as process:
        assert process.stdout is not None
        try:
            guard.install()
            while chunk := os.read(process.stdout.fileno(), 4096):
                printed += chunk
                show(chunk.decode("utf-8", "replace"))
            return process.wait(), printed.decode("utf-8", "replace")
        except BaseException:
            guard.held = True
            system.end_group(process, 5.0)
            if UPLOADING.encode() in printed:
                show("\nthe board may hold half a program: flash it again before use\n")
            raise
        finally:
            guard.restore()
