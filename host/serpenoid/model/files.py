"""Read JSON of a size that memory bears; write files whole or not at all."""

from __future__ import annotations

import csv
import json
import os
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NoReturn

from ..base.errors import BadInput, SerpenoidError
from ..base.files import read_text

# Control characters, which a terminal obeys, are written out as \x1b, but for line ends and tabs.
_CONTROL = (*range(32), *range(127, 160))
_WRITTEN = {k: f"\\x{k:02x}" for k in _CONTROL if chr(k) not in "\n\t"}


def read_json(path: Path) -> Any:
    """Return what a JSON file holds; raises BadInput. NaN and Infinity are no JSON."""
    text = read_text(path)
    try:
        return json.loads(text, parse_constant=_refuse_constant)
    except RecursionError:
        raise BadInput(f"{path}: not JSON of this program: lists in lists without end") from None
    except ValueError as error:
        raise BadInput(f"{path}: not JSON: {error}") from None


def _refuse_constant(name: str) -> NoReturn:
    raise ValueError(f"{name} is no number in JSON")


def visible(text: str) -> str:
    """Return a text from outside as a terminal may have it: what it obeys written out."""
    return text.translate(_WRITTEN)


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
        if error.filename != str(part):
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
