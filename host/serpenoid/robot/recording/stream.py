"""A recorded run, read back into arrays: damage on the wire is counted, all else is kept."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from ...base.errors import BadInput, ClockWrong, DamagedLine
from ...base.files import check_file
from ..wire.clock import BoardClock
from ..wire.protocol import Hello, Telemetry, parse
from .recorder import TITLE

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


@dataclass(frozen=True)
class Stream:
    """A recorded run of N frames; arrays have one row a frame, joints count from the tail.

    host_s (N,): arrival since the start. frame (N,): the board's count.
    board_s (N,): the board's time, wraps undone. phase_rad (N,), setpoint_rad (N, joints), pulse_us
    (N, joints), exec_us (N,), late_us (N,), clipped (N,), state (N,): as in the telemetry of
    PROTOCOL.md. sent, reports: all lines to the board, and those from it that are not telemetry, as
    (host_s, text).
    damaged: lines from the board that cannot be trusted: a wrong CRC, too many bytes, a clock that
    hops, another number of joints. end: how the run ended, None if it was cut off.
    """

    host_s: NDArray[np.float64]
    frame: NDArray[np.int64]
    board_s: NDArray[np.float64]
    phase_rad: NDArray[np.float64]
    setpoint_rad: NDArray[np.float64]
    pulse_us: NDArray[np.int64]
    exec_us: NDArray[np.int64]
    late_us: NDArray[np.int64]
    clipped: NDArray[np.int64]
    state: NDArray[np.str_]
    sent: tuple[tuple[float, str], ...]
    reports: tuple[tuple[float, str], ...]
    damaged: int
    end: str | None


def load_stream(path: Path) -> Stream:
    """Read a recording, complete or cut off; raise BadInput if it is none."""
    rows = _rows(Path(path))
    title = next(rows, (1, b""))[1].decode("ascii", "replace")
    if not title.startswith(TITLE):
        raise BadInput(f"{path} is no recording: it starts with {title[:40]!r}, not {TITLE!r}")
    reading = _Reading(Path(path))
    for number, row in rows:
        reading.take(number, row)
    return reading.stream()


def _rows(path: Path) -> Iterator[tuple[int, bytes]]:
    """Yield the rows that are whole, counted from 1."""
    check_file(path, 1 << 28)  # eight hours of telemetry, which take a gigabyte of memory
    with path.open("rb") as file:
        for number, row in enumerate(file, 1):
            if row.endswith(b"\n"):  # else it is half a row
                yield number, row.removesuffix(b"\n")


class _Reading:
    """Take a recording's rows one by one, and make arrays of them."""

    def __init__(self, path: Path):
        self._path = path
        self._last_s = 0.0
        self._sent: list[tuple[float, str]] = []
        self._reports: list[tuple[float, str]] = []
        self._damaged = 0
        self._end: str | None = None
        self._joints = 0  # joints of the greeting or the first frame, whichever comes first
        self._clock = BoardClock()
        self._frames: list[tuple[float, int, Telemetry]] = []

    def take(self, number: int, row: bytes) -> None:
        """Take one row; raise BadInput, with its number, if it is not as Recorder writes it."""
        try:
            if row.startswith(b"# end: "):
                self._end = row.removeprefix(b"# end: ").decode("utf-8", "replace")
            elif not row.startswith(b"#"):
                self._line(*self._parts(row))
        except ValueError as error:  # no row of a recording, or time runs backwards
            raise BadInput(f"{self._path}:{number}: {row[:60]!r} ({error})") from None

    def stream(self) -> Stream:
        """Return all that was taken."""
        import numpy as np

        hosts_s, boards_us, frames = (
            zip(*self._frames, strict=True) if self._frames else ((), (), ())
        )
        names = [name for name in Telemetry.__slots__ if name in Stream.__dataclass_fields__]
        columns = {name: np.array([getattr(frame, name) for frame in frames]) for name in names}
        for name in ("setpoint_rad", "pulse_us"):
            columns[name] = columns[name].reshape(len(frames), self._joints)
        columns |= {
            "host_s": np.array(hosts_s),
            "board_s": 1e-6 * np.array(boards_us),
            "state": columns["state"].astype(str),
        }
        return Stream(
            sent=tuple(self._sent),
            reports=tuple(self._reports),
            damaged=self._damaged,
            end=self._end,
            **columns,
        )

    def _parts(self, row: bytes) -> tuple[float, str, bytes]:
        parts = re.fullmatch(rb"(\d{1,12}(?:\.\d{1,9})?) ([<>]) (.*)", row, re.DOTALL)
        if not parts:
            raise ValueError("it is not `SECONDS < LINE` or `SECONDS > LINE`")
        seconds, direction, text = parts.groups()
        host_s = float(seconds)
        if host_s < self._last_s:
            raise ValueError(f"time is {seconds.decode()} after {self._last_s}: it runs backwards")
        self._last_s = host_s
        return host_s, direction.decode(), text.decode("unicode_escape").encode("latin-1")

    def _line(self, host_s: float, direction: str, text: bytes) -> None:
        if direction == ">":
            self._sent.append((host_s, text.decode("latin-1")))
            return
        try:
            message = parse(text)
            if isinstance(message, Telemetry):
                return self._keep(host_s, message)
        except (ClockWrong, DamagedLine):
            self._damaged += 1
            return None
        self._reports.append((host_s, text.decode("ascii")))
        if isinstance(message, Hello):
            self._joints = self._joints or message.joints
            self._clock.frame_us = message.frame_us
        return None

    def _keep(self, host_s: float, frame: Telemetry) -> None:
        """Add a frame."""
        self._joints = self._joints or len(frame.setpoint_rad)
        if self._joints != len(frame.setpoint_rad):
            raise DamagedLine(f"a frame has another number of joints than {self._joints}")
        board_us = self._clock.unwrap(frame.frame, frame.board_us)
        self._frames.append((host_s, board_us, frame))
