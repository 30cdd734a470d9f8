"""Read regular files of a size that memory bears, as bytes, as text or as cells of a CSV file."""

from __future__ import annotations

import csv
import io
import stat
from pathlib import Path

from .errors import BadInput

MOST_BYTES = 16_000_000  # of a file that people or this program write as text


def check_file(path: Path, most_bytes: int = MOST_BYTES) -> int:
    """Return the size of a regular file in bytes.

    Raises
    ------
    BadInput
        There is no such file, it is a folder, a device or a pipe, or it is too large.
    """
    try:
        about = path.stat()
    except (OSError, ValueError) as error:  # ValueError: a name with a zero byte
        raise BadInput(f"{path}: {getattr(error, 'strerror', None) or error}") from error
    if not stat.S_ISREG(about.st_mode):
        kind = "a folder" if stat.S_ISDIR(about.st_mode) else "a device, a pipe or a socket"
        raise BadInput(f"{path}: this is {kind}; give the name of a regular file")
    if about.st_size > most_bytes:
        raise BadInput(
            f"{path}: the file has {about.st_size} bytes; the most is {most_bytes}; is it the "
            "right one?"
        )
    return about.st_size


def read_bytes(path: Path, most_bytes: int = MOST_BYTES) -> bytes:
    """Return the bytes of a regular file; raises BadInput."""
    check_file(path, most_bytes)
    try:
        with path.open("rb") as file:
            return file.read(most_bytes)
    except OSError as error:
        raise BadInput(f"{path}: {error.strerror or error}") from error


def read_text(path: Path, most_bytes: int = MOST_BYTES) -> str:
    """Return a UTF-8 file's text with line ends as LF; raises BadInput."""
    try:
        text = read_bytes(path, most_bytes).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise BadInput(f"{path}: not UTF-8 text at byte {error.start}; save it as UTF-8") from error
    return with_line_feeds(text)


def with_line_feeds(text: str) -> str:
    """Return a text whose line ends, of whatever system, are LF."""
    return text.replace("\r\n", "\n").replace("\r", "\n")


def csv_rows(text: str, path: Path | None = None, delimiter: str = ",") -> list[list[str]]:
    """Return the rows of a CSV text; raises BadInput, naming the line of the file if given."""
    rows = csv.reader(io.StringIO(text, newline=""), delimiter=delimiter, strict=True)
    try:
        return list(rows)
    except csv.Error as error:
        where = f"{path}:{rows.line_num}: " if path else ""
        raise BadInput(f"{where}not CSV: {error}") from error
