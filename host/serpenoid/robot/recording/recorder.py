"""Write a run to disk as it happens, line by line, by a thread that alone waits for the disk."""

from __future__ import annotations

import atexit
import os
import queue
import threading
from contextlib import suppress
from dataclasses import dataclass
from datetime import datetime, timezone
from io import FileIO
from pathlib import Path

from ...base.errors import BadInput, RecordingFailed

TITLE = "# serpenoid wire 1"
DISK_S = 2.0  # time for the disk to take the first row, and all that waits at the end


@dataclass
class Row:
    """A row on its way to the disk: a remark, or direction, line and host time in s."""

    text: str
    line: bytes | None = None
    host_s: float = 0.0
    written: bool = False


class Recorder:
    """Write every line of a run to a file within milliseconds; a stalled disk stops nothing.

    Each row is `SECONDS < LINE` or `SECONDS > LINE`; bytes that are not printable are escaped
    as in Python. The last row, `# end: ...`, says how the run ended. Raises BadInput for a file
    that has content already, RecordingFailed when the disk takes no more. Safe from any thread
    and from a signal handler: rows wait in memory, some 40 MB for an hour.
    """

    def __init__(self, path: Path, start_s: float):
        self.path = path
        self._start_s = start_s
        self._queue: queue.SimpleQueue[Row | None] = queue.SimpleQueue()
        self._closed = False
        self._failure: RecordingFailed | None = None
        self._progress = threading.Condition()
        self._process = os.getpid()
        self._file = _open(path)
        self._thread = threading.Thread(target=self._write_on, name="serpenoid disk", daemon=True)
        try:
            self._begin()
        except BaseException:
            self._queue.put(None)
            self.discard()
            raise

    def _begin(self) -> None:
        atexit.register(self._at_exit)
        self._thread.start()
        begun = datetime.now(timezone.utc).isoformat(timespec="milliseconds")
        columns = "# seconds since the start, < from or > to the board, the line with its CRC"
        head = Row(f"{TITLE}, begun {begun}\n{columns}")
        self._queue.put(head)
        if not self._wait(head, DISK_S) or self._failure:
            raise self._failure or self._failed(f"it took nothing for {DISK_S:g} s")

    def line(self, host_s: float, direction: str, line: bytes) -> None:
        """Add one line; direction is `<` or `>`. After close() it is lost."""
        if self._failure:
            raise self._failure
        if not self._closed:
            self._queue.put(Row(direction, line, host_s))

    def close(self, how: str = "closed") -> None:
        """Say how the run ended and close the file; harmless when done twice.

        Raises RecordingFailed if lines were lost, or are not on the disk after two seconds.
        """
        if self._closed:
            return
        self._closed = True
        atexit.unregister(self._at_exit)
        end = Row(f"# end: {how}")
        self._queue.put(end)
        self._queue.put(None)
        if self._wait(end, DISK_S):
            self._thread.join(DISK_S)
        if self._failure:
            raise self._failure
        if not end.written:
            rows = self._queue.qsize()
            raise self._failed(f"the disk stalled, and {rows} rows could not be written")

    def discard(self) -> None:
        """Remove the recording of a run that never began, so that its name is free again."""
        self._closed = True
        atexit.unregister(self._at_exit)
        if self.path.is_file():
            self.path.unlink()

    def _at_exit(self) -> None:
        """Close the recording at exit if the program did not; a forked process does nothing."""
        if os.getpid() == self._process:
            with suppress(RecordingFailed):
                self.close("the program ended without leaving the robot")

    def _wait(self, row: Row, most_s: float) -> bool:
        """Wait until a row, and all before it, is written; return whether it is."""
        with self._progress:
            return self._progress.wait_for(lambda: row.written, most_s)

    def _write_on(self) -> None:
        last_s = 0.0
        while (row := self._queue.get()) is not None:
            if row.line is None:
                text = f"{row.text}\n".encode("utf-8", "backslashreplace")
            else:
                last_s = max(last_s, row.host_s - self._start_s)  # threads may enter out of turn
                line = row.line.rstrip(b"\r\n").decode("latin-1").encode("unicode_escape")
                text = b"%.6f %b %b\n" % (last_s, row.text.encode(), line)
            if not self._failure:
                self._write(text)
            with self._progress:
                row.written = True
                self._progress.notify_all()
        self._file.close()

    def _write(self, text: bytes) -> None:
        try:
            while text:
                text = text[self._file.write(text) :]
        except OSError as error:
            self._failure = self._failed(f"{error.strerror}")

    def _failed(self, why: str) -> RecordingFailed:
        return RecordingFailed(
            f"recording to {self.path} ended: {why}; what is in it is whole: free some space or "
            "record to another disk"
        )


def refuse_existing(path: Path) -> None:
    """Raise BadInput where a recording would write over something."""
    if path.is_file() and path.stat().st_size:
        raise BadInput(f"{path} holds something already; give the recording another name")


def _open(path: Path) -> FileIO:
    """Open a new file. Raises BadInput where a recording would write over something."""
    refuse_existing(path)
    try:
        return FileIO(path, "w")
    except OSError as error:
        raise RecordingFailed(
            f"cannot record to {path}: {error.strerror}; choose another"
        ) from error
