"""Write a session's folder: a line for each reading, which is on the disk before the next step.

Only one process at a time writes, and it only appends. A line that a kill or a power cut has cut
short is ended with a mark before the next one; a line for which the disk has no room is removed.
"""

from __future__ import annotations

import csv
import errno
import io
import os
from datetime import datetime, timezone
from importlib.metadata import version
from io import FileIO
from pathlib import Path
from typing import Any

from ..base import system
from ..base.errors import BadInput, RecordingFailed
from .declaration import Cells
from .folder import (
    EVENT_COLUMNS,
    LINKS,
    ON_READINGS,
    READING_COLUMNS,
    TORN,
    TRACK_WORDS,
    Row,
    check_session,
    kind_of,
    make_reading,
    numbered_rows,
    read_session,
    reading_row,
)
from .session import Session
from .settings import changes
from .track import PLACES, Samples, Track, typed_track

PROGRAM = f"serpenoid {version('serpenoid')}"  # Name and version of the program in files.


def utc_now() -> str:
    """Return the present time as in files, ISO 8601 in UTC."""
    return datetime.now(timezone.utc).isoformat(timespec="milliseconds").replace("+00:00", "Z")


class Journal:
    """The writer of one session, used as `with Journal(folder) as journal:`.

    session: the session as the files hold it now. rows: the rows of readings by their numbers.
    Raises BadInput for files that cannot be read, or if another process, which it names, writes to
    the session; RecordingFailed if the disk is full, and no line is then half written.
    """

    def __init__(self, folder: str | Path):
        self.folder = Path(folder)
        self._lock: FileIO | None = None
        self.session: Session
        self.rows: dict[int, Row]

    def __enter__(self) -> Journal:
        check_session(self.folder)
        try:
            self._take_lock()
            self._read()
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *error: object) -> None:
        if self._lock:
            self._lock.close()
            self._lock = None

    @property
    def last(self) -> int:
        """Return the number of the last reading, 0 if there is none."""
        return max(self.rows, default=0)

    def add(
        self,
        kind: str,
        cells: Cells,
        *,
        replaces: int = 0,
        comment: str = "",
        samples: Samples | None = None,
    ) -> int:
        """Check and write one reading; return its number.

        cells: column -> value, in the file's units. replaces: number of a reading that it makes
        void. samples: of a kind with a track, whose file is written before the reading's line.
        """
        if replaces:
            self._check_number(replaces)
        number = self.last + 1
        row, track = self.check(kind, cells, samples)
        if track is not None:
            words = track.write(self.folder, number), track.sha256
            row["more"] += "".join(map(" {}={}".format, TRACK_WORDS, words))
        row |= {"reading": str(number), "time_utc": utc_now(), "setup": "1", "comment": comment}
        self._append("readings.csv", READING_COLUMNS, row | {"replaces": str(replaces or "")})
        return number

    def check(
        self, kind: str, cells: Cells, samples: Samples | None = None
    ) -> tuple[dict[str, str], Track | None]:
        """Return the row and the track of a reading; raises BadInput if it is not valid."""
        setup, declared = self.session.setup, kind_of(kind)
        cells = {**cells, LINKS: setup.robot.links}
        if declared.columns and (places := cells.pop(PLACES, "")):
            samples = typed_track(str(places))
        row, sha256 = reading_row(kind, cells, setup.plan), cells.get("film_sha256")
        for film in self.session.kept_films:
            if sha256 and film.film_sha256 == sha256:
                raise BadInput(f"reading {film.number} is of this film already")
        track = None if samples is None else Track.from_samples(declared.columns, samples)
        if track is None and declared.columns and not declared.track_may_miss:
            raise BadInput(
                f"a reading of kind {kind} needs its track, {', '.join(declared.columns)}; "
                "`serpenoid video FILE --session DIR` adds a film"
            )
        common: dict[str, Any] = {"number": 1} | ({"track": track} if track is not None else {})
        make_reading(row, common)
        return row, track

    def _check_number(self, reading: int) -> None:
        """Raise BadInput unless there is a reading of this number."""
        if reading not in self.rows:
            numbers = f"1 to {self.last}" if self.rows else "none yet"
            raise BadInput(f"there is no reading {reading}; there are {numbers}")

    def event(self, event: str, reading: int = 0, detail: str = "") -> None:
        """Write one event; void and undo need a reading that is there."""
        if event in ON_READINGS:
            self._check_number(reading)
        row = {"time_utc": utc_now(), "event": event, "reading": str(reading or "")}
        self._append("events.csv", EVENT_COLUMNS, row | {"detail": detail})

    def read_again(self) -> list[str]:
        """Read the files again; return the changes in session.toml, a line for each setting."""
        setup = self.session.setup
        self._read()
        return changes(setup, self.session.setup)

    def _read(self) -> None:
        self.session = read_session(self.folder)
        self.rows = numbered_rows(self.folder / "readings.csv", [])

    def _take_lock(self) -> None:
        path = self.folder / ".lock"
        try:
            self._lock = path.open("a+b", buffering=0)
            if not system.lock(self._lock.fileno()):
                self._lock.seek(0)
                holder = self._lock.read(20).decode("ascii", "replace").strip() or "unknown"
                raise BadInput(
                    f"{self.folder}: process {holder} is writing to this session already; leave it "
                    "there, or end that one first"
                )
            self._lock.truncate(0)
            self._lock.write(f"{os.getpid()}\n".encode())
        except OSError as error:
            raise RecordingFailed(
                f"{path}: {error.strerror}: nothing could be kept; is the folder yours, and is "
                "there room on its disk?"
            ) from error

    def _append(self, name: str, columns: tuple[str, ...], row: Row) -> None:
        if not self._lock:
            raise BadInput("the session is not open; use it inside `with Journal(folder)`")
        append_line(self.folder / name, csv_line([row.get(column, "") for column in columns]))
        self._read()


def csv_line(cells: list[str]) -> str:
    """Return one line of CSV; line ends inside cells become spaces."""
    line = io.StringIO()
    csv.writer(line, lineterminator="\n").writerow([" ".join(cell.split()) for cell in cells])
    return line.getvalue()


def append_line(path: Path, line: str) -> None:
    """Append a line or more to a file on the disk, whole or not at all.

    Raises RecordingFailed.
    """
    try:
        with path.open("r+b", buffering=0) as file:
            size = file.seek(0, os.SEEK_END)
            file.seek(max(size - 1, 0))
            is_torn = file.read(1) not in (b"", b"\n")
            data = (f"{TORN}\n" * is_torn + line).encode()
            try:
                if file.write(data) < len(data):
                    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
                os.fsync(file.fileno())
            except OSError:
                file.truncate(size)
                raise
    except OSError as error:
        raise RecordingFailed(
            f"{path}: {error.strerror}: this is not saved, all before it is; make room on the "
            "disk, then type it again"
        ) from error
