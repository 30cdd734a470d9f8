"""A run on disk as it happens, line by line, and back into arrays."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime, timezone
from pathlib import Path
from typing import TYPE_CHECKING

from ...model.errors import BadInput, DamagedLine, RecordingFailed
from .clock import BoardClock
from .protocol import Telemetry, parse

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

TITLE = "# serpenoid wire 1"
COLUMNS = "# seconds since the start, < from or > to the board, the line with its CRC"


class Recorder:
    """Write every line of a run to a file at once, so that a kill loses at most the last one.

    Each row is `SECONDS < LINE` or `SECONDS > LINE`; bytes that are not printable are escaped
    as in Python. The last row, `# end: ...`, says how the run ended. Raises BadInput for a file
    that has content already, RecordingFailed when the disk takes no more.
    """

    def __init__(self, path: Path, start_s: float):
        self.path = path
        self._start_s = start_s
        if path.is_file() and path.stat().st_size:
            raise BadInput(f"{path} holds something already; give the recording another name")
        try:
            self._file = path.open("wb", buffering=0)
        except OSError as error:
            raise RecordingFailed(f"cannot record to {path}: {error}; choose another") from error
        begun = datetime.now(timezone.utc).isoformat(timespec="milliseconds")
        self._write(f"{TITLE}, begun {begun}\n{COLUMNS}\n".encode())

    def line(self, host_s: float, direction: str, line: bytes) -> None:
        """Add one line; direction is `<` or `>`."""
        text = line.rstrip(b"\r\n").decode("latin-1").encode("unicode_escape")
        self._write(b"%.6f %b %b\n" % (host_s - self._start_s, direction.encode(), text))

    def close(self, how: str = "closed") -> None:
        """Say how the run ended and close the file; harmless when done twice."""
        if self._file.closed:
            return
        try:
            self._write(f"# end: {how}\n".encode())
        finally:
            self._file.close()

    def discard(self) -> None:
        """Remove the recording of a run that never began, so that its name is free again."""
        if self.path.is_file():
            self.path.unlink()

    def _write(self, row: bytes) -> None:
        try:
            written = self._file.write(row)
        except OSError as error:
            raise self._failed(str(error)) from error
        if written != len(row):
            raise self._failed("only part of a line was written")

    def _failed(self, why: str) -> RecordingFailed:
        return RecordingFailed(
            f"recording to {self.path} ended: {why}; what is in it is whole: free some space or "
            "record to another disk"
        )


@dataclass(frozen=True)
class Stream:
    """A recorded run of N frames; arrays have one row a frame, joints count from the tail.

    begun: UTC, ISO 8601. host_s (N,): arrival since the start. frame (N,): the board's count.
    board_s (N,): the board's time, wraps undone. phase_rad (N,), setpoint_rad (N, 5), pulse_us
    (N, 5), exec_us (N,), late_us (N,), state (N,): as in the telemetry of PROTOCOL.md. sent,
    said: all lines to the board, and those from it that are not telemetry, as (host_s, text).
    damaged: lines from the board that cannot be trusted. end: how the run ended, None if it was
    cut off.
    """

    begun: str
    host_s: NDArray[np.float64]
    frame: NDArray[np.int64]
    board_s: NDArray[np.float64]
    phase_rad: NDArray[np.float64]
    setpoint_rad: NDArray[np.float64]
    pulse_us: NDArray[np.int64]
    exec_us: NDArray[np.int64]
    late_us: NDArray[np.int64]
    state: NDArray[np.str_]
    sent: tuple[tuple[float, str], ...]
    said: tuple[tuple[float, str], ...]
    damaged: int
    end: str | None


def load_stream(path: Path) -> Stream:
    """Read a recording, complete or cut off; raise BadInput if it is none."""
    try:
        rows = Path(path).read_bytes().split(b"\n")
    except OSError as error:
        raise RecordingFailed(f"cannot read {path}: {error}") from error
    title = rows[0].decode("ascii", "replace")
    if not title.startswith(TITLE):
        raise BadInput(f"{path} is no recording: it starts with {title[:40]!r}, not {TITLE!r}")
    end, sent, said, damaged = None, [], [], 0
    frames: list[tuple[float, Telemetry]] = []
    for row in rows[1:-1]:  # behind the last line end there is nothing, or half a row
        if row.startswith(b"#"):
            end = row.decode().removeprefix("# end: ") if row.startswith(b"# end: ") else end
            continue
        host_s, direction, text = _row(path, row)
        if direction == ">":
            sent.append((host_s, text.decode("latin-1")))
            continue
        try:
            message = parse(text)
        except DamagedLine:
            damaged += 1
            continue
        if isinstance(message, Telemetry):
            frames.append((host_s, message))
        else:
            said.append((host_s, text.decode("ascii")))
    return _stream(title.rpartition(" ")[2], frames, tuple(sent), tuple(said), damaged, end)


def _row(path: Path, row: bytes) -> tuple[float, str, bytes]:
    seconds, _, rest = row.partition(b" ")
    direction, _, text = rest.partition(b" ")
    try:
        return float(seconds), direction.decode(), text.decode("unicode_escape").encode("latin-1")
    except ValueError as error:
        raise BadInput(f"{path}: {row[:60]!r} is not `SECONDS < LINE` ({error})") from None


def _stream(
    begun: str,
    frames: list[tuple[float, Telemetry]],
    sent: tuple[tuple[float, str], ...],
    said: tuple[tuple[float, str], ...],
    damaged: int,
    end: str | None,
) -> Stream:
    import numpy as np

    clock, n = BoardClock(), len(frames)
    board_us = [clock.unwrap(f.frame, f.board_us) for _, f in frames]
    f = [frame for _, frame in frames]
    return Stream(
        begun,
        np.array([host_s for host_s, _ in frames]),
        np.array([x.frame for x in f], dtype=np.int64),
        np.array(board_us) * 1e-6,
        np.array([x.phase_rad for x in f]),
        np.array([x.setpoint_rad for x in f], dtype=float).reshape(n, 5),
        np.array([x.pulse_us for x in f], dtype=np.int64).reshape(n, 5),
        np.array([x.exec_us for x in f], dtype=np.int64),
        np.array([x.late_us for x in f], dtype=np.int64),
        np.array([x.state for x in f], dtype=str),
        sent,
        said,
        damaged,
        end,
    )
