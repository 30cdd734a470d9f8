"""Read regular files of bearable size (text, CSV, JSON); write files whole or not at all."""

from __future__ import annotations

import csv
import io
import json
import os
import re
import stat
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NoReturn

from .errors import BadInput, SerpenoidError

MOST_BYTES = 16_000_000  # bytes of a file that people or this program write as text


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
        return path.read_bytes()
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


def read_json(path: Path) -> Any:
    """Return what a JSON file holds; raises BadInput. NaN and Infinity are no JSON."""
    text = read_text(path)
    try:
        return json.loads(text, parse_constant=_refuse_constant)
    except (RecursionError, ValueError) as error:
        raise BadInput(f"{path}: not JSON: {error}") from None


def _refuse_constant(name: str) -> NoReturn:
    raise ValueError(f"{name} is no number in JSON")


def visible(text: str) -> str:
    r"""Return a text from outside whose control characters, but line ends and tabs, are as \x1b."""
    controls = r"[\x00-\x08\x0b-\x1f\x7f-\x9f]"
    return re.sub(controls, lambda match: f"\\x{ord(match[0]):02x}", text)


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """Give the path of a part beside a file, of the same suffix; put it in the file's place.

    The part is on the disk before it replaces the file. An error, Ctrl-C or SIGTERM leaves the old
    file and no part. A device or a pipe is written to directly. Raises OSError.
    """
    target = Path(os.path.realpath(path))
    if target.exists() and not target.is_file():
        yield target
        return
    part = target.with_name(f".{os.getpid()}.part.{target.name}")
    try:
        yield part
        with part.open("r+b") as file:  # Windows puts on the disk what may be written to alone
            os.fsync(file.fileno())
        part.replace(target)
    except OSError as error:
        if error.filename not in (None, str(part)):
            raise
        raise OSError(error.errno, error.strerror, str(path)) from None  # nobody knows of the part
    finally:
        part.unlink(missing_ok=True)


def write_text(path: Path, text: str) -> None:
    """Write a UTF-8 file whole, with line ends as LF. Raises OSError."""
    with whole_file(path) as part:
        part.write_text(text, encoding="utf-8", newline="")


def write_named(path: str | Path, text: str) -> None:
    """Write a text file that a caller named, whole or not at all. Raises SerpenoidError."""
    try:
        write_text(Path(path), text)
    except OSError as error:
        raise SerpenoidError(
            f"{path}: cannot be written: {error.strerror or error}; choose another place"
        ) from error


def write_csv(path: Path, header: Sequence[str], rows: Iterable[Sequence[Any]]) -> None:
    """Write a CSV file whole; numbers by their shortest exact digits. Raises OSError."""
    with whole_file(path) as part, part.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(header)
        writer.writerows(rows)
