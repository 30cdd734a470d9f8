"""Functions that differ between Linux, macOS and Windows: locks, keys, signals, programs, ports.

Only this module imports modules that some of these systems lack.
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


def signals(*names: str) -> tuple[signal.Signals, ...]:
    """Return the named signals that this system has."""
    return tuple(getattr(signal, name) for name in names if hasattr(signal, name))


ENDING = signals("SIGTERM", "SIGHUP", "SIGQUIT", "SIGBREAK")  # They end a program.
SUSPENDING = signals("SIGTSTP")  # Ctrl-Z


def lock(fd: int) -> bool:
    """Lock an open file for this process; return False if another process has locked it."""
    with suppress(ImportError):  # Without fcntl nothing is locked.
        try:
            if WINDOWS:
                import msvcrt

                console: Any = msvcrt  # Type checkers know it on Windows only.
                os.lseek(fd, 1 << 30, os.SEEK_SET)  # behind all that is written in the file
                console.locking(fd, console.LK_NBLCK, 1)
            else:
                import fcntl

                fcntl.flock(fd, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            return False
    return True


@contextmanager
def single_keys() -> Iterator[None]:
    """Let the terminal at standard input pass each key at once, without echo, Ctrl-Z too."""
    try:
        import termios
    except ImportError:  # Windows passes single keys anyway.
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
        with suppress(termios.error):  # The terminal may be closed.
            termios.tcsetattr(fd, termios.TCSANOW, original)


def read_input(timeout_s: float) -> bytes | None:
    """Return bytes from standard input, b"" at its end, None if none came within timeout_s.

    On Windows the timeout does not apply to pipes.
    """
    if WINDOWS and sys.stdin.isatty():
        return _read_console(timeout_s)
    import select

    if not WINDOWS and not select.select([sys.stdin], [], [], timeout_s)[0]:
        return None
    with suppress(OSError):  # A closed terminal counts as the end of input.
        return os.read(sys.stdin.fileno(), 4096)
    return b""


def forget_input() -> None:
    """Discard input that was typed ahead at the terminal."""
    if WINDOWS:
        while _read_console(0.0):
            pass
    with suppress(ImportError):
        import termios

        termios.tcflush(sys.stdin.fileno(), termios.TCIFLUSH)


def _read_console(timeout_s: float) -> bytes | None:
    import msvcrt

    console: Any = msvcrt  # Type checkers know it on Windows only.
    end_s = time.monotonic() + timeout_s
    while not console.kbhit():
        if time.monotonic() >= end_s:
            return None
        time.sleep(0.01)
    key = console.getwch()
    if key in "\0\xe0":  # The prefix of an arrow or function key.
        arrows = {"H": "\x1b[A", "P": "\x1b[B", "M": "\x1b[C", "K": "\x1b[D"}
        key = arrows.get(console.getwch(), "")
    return {"\x03": "", "\x1a": "\x04"}.get(key, key).encode()


def start_group(command: list[str], env: Mapping[str, str]) -> subprocess.Popen[bytes]:
    """Start a program in a separate process group, which Ctrl-C at the terminal does not reach."""
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
    """End a program and all processes that it has started; kill them after grace_s."""
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
    """Forbid other programs to open a serial port that is open here, or allow it again."""
    # The lock belongs to the port: it outlives this program if another one has the port open too.
    with suppress(ImportError, OSError):  # Ports of Windows are exclusive; a port may be unplugged.
        import fcntl
        import termios

        fcntl.ioctl(port.fileno(), termios.TIOCEXCL if exclude else termios.TIOCNXCL)


def group_of(path: str) -> str | None:
    """Return the name of the group that owns a file; None if it is unknown."""
    with suppress(ImportError, OSError, KeyError):
        import grp

        return grp.getgrgid(os.stat(path).st_gid).gr_name
    return None


def usb_vendors() -> set[str]:
    """Return the vendor ids of the USB devices on Linux, in hexadecimal digits."""
    files = Path("/sys/bus/usb/devices").glob("*/idVendor")
    with suppress(OSError):  # a device may be unplugged meanwhile
        return {file.read_text(encoding="utf-8").strip() for file in files}
    return set()
