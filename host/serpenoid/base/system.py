"""What Linux, macOS and Windows do each in its way: locks, keys, signals, programs, ports.

The rest of the package imports no module that only some of these systems have.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from _typeshed import HasFileno

WINDOWS = sys.platform == "win32"
USB = Path("/sys/bus/usb/devices")
LOCK_OFFSET = 1 << 30  # a lock there hides nothing that is written in the file
NAP_S = 0.01  # between two looks for a key of Windows
KEYS_OF_WINDOWS = {"H": "\x1b[A", "P": "\x1b[B", "M": "\x1b[C", "K": "\x1b[D"}


def signals(*names: str) -> tuple[signal.Signals, ...]:
    """Return those of the named signals that this system has."""
    return tuple(getattr(signal, name) for name in names if hasattr(signal, name))


ENDING = signals("SIGTERM", "SIGHUP", "SIGQUIT", "SIGBREAK")  # they would kill without a word
SUSPENDING = signals("SIGTSTP")  # Ctrl-Z


def lock(fd: int) -> bool:
    """Lock an open file for this process alone; return False where another one has it."""
    with suppress(ImportError):  # then nothing is locked
        try:
            if WINDOWS:
                import msvcrt

                console: Any = msvcrt  # whose functions other systems do not have
                os.lseek(fd, LOCK_OFFSET, os.SEEK_SET)
                console.locking(fd, console.LK_NBLCK, 1)
            else:
                import fcntl

                fcntl.flock(fd, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            return False
    return True


@contextmanager
def single_keys() -> Iterator[None]:
    """Let the terminal at standard input give each key at once, unseen; Ctrl-Z is a key, too."""
    try:
        import termios
    except ImportError:  # Windows gives single keys anyway
        yield
        return
    fd = sys.stdin.fileno()
    original, keys = termios.tcgetattr(fd), termios.tcgetattr(fd)
    keys[3] &= ~(termios.ICANON | termios.ECHO)
    keys[6][termios.VSUSP] = bytes([os.fpathconf(fd, "PC_VDISABLE")])
    termios.tcsetattr(fd, termios.TCSANOW, keys)
    try:
        yield
    finally:
        with suppress(termios.error):  # it may be gone
            termios.tcsetattr(fd, termios.TCSANOW, original)


def read_input(timeout_s: float) -> bytes | None:
    """Return what came on standard input, b"" at its end, None if nothing came in time.

    Windows waits for a pipe as long as it takes.
    """
    if WINDOWS and sys.stdin.isatty():
        return _read_console(timeout_s)
    import select

    if not WINDOWS and not select.select([sys.stdin], [], [], timeout_s)[0]:
        return None
    with suppress(OSError):  # a terminal that was closed has ended, too
        return os.read(sys.stdin.fileno(), 4096)
    return b""


def forget_input() -> None:
    """Drop what was typed ahead at the terminal."""
    if WINDOWS:
        while _read_console(0.0):
            pass
    with suppress(ImportError):
        import termios

        termios.tcflush(sys.stdin.fileno(), termios.TCIFLUSH)


def _read_console(timeout_s: float) -> bytes | None:
    import msvcrt

    console: Any = msvcrt  # whose functions other systems do not have
    end_s = time.monotonic() + timeout_s
    while not console.kbhit():
        if time.monotonic() >= end_s:
            return None
        time.sleep(NAP_S)
    key = console.getwch()
    if key in "\0\xe0":  # an arrow or the like: its name comes next
        key = KEYS_OF_WINDOWS.get(console.getwch(), "")
    return {"\x03": "", "\x1a": "\x04"}.get(key, key).encode()


def start_group(command: list[str], env: Mapping[str, str]) -> subprocess.Popen[bytes]:
    """Start a program in a group of its own, which Ctrl-C at the terminal does not reach."""
    return subprocess.Popen(
        command,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        start_new_session=True,
        creationflags=getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0),
        env=env,
    )


def end_group(process: subprocess.Popen[bytes], grace_s: float) -> None:
    """End a program and all that it has started, in order first and then by force."""
    with suppress(ProcessLookupError, subprocess.TimeoutExpired):
        if WINDOWS:
            process.send_signal(getattr(signal, "CTRL_BREAK_EVENT", signal.SIGTERM))
        else:
            os.killpg(process.pid, signal.SIGINT)
        process.wait(grace_s)
    with suppress(ProcessLookupError):
        if WINDOWS:
            process.kill()
        else:
            os.killpg(process.pid, signal.SIGKILL)


def exclude_others(port: HasFileno, exclude: bool) -> None:
    """Keep other programs out of a serial port that is open here, or let them in again."""
    # It belongs to the terminal and would outlive this program where another has it open as well.
    with suppress(ImportError, OSError):  # a system whose ports are exclusive anyway; unplugged
        import fcntl
        import termios

        fcntl.ioctl(port.fileno(), termios.TIOCEXCL if exclude else termios.TIOCNXCL)


def group_of(path: str) -> str | None:
    """Return the group that a file belongs to, None where that is not known."""
    with suppress(ImportError, OSError, KeyError):
        import grp

        return grp.getgrgid(os.stat(path).st_gid).gr_name
    return None


def usb_vendors() -> set[str]:
    """Return the vendors of the USB devices that Linux shows, as hexadecimal numbers."""
    return {_word(vendor) for vendor in USB.glob("*/idVendor")}


def _word(path: Path) -> str:
    """Return what the system tells in a file of one word; nothing if it is gone."""
    with suppress(OSError):
        return path.read_text(encoding="utf-8").strip()
    return ""
