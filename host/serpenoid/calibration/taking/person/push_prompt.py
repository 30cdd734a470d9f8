"""What the dialogue asks after a push: a file of its track, or way and time by tape and watch."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ....model.errors import BadInput
from ...floor.track_files import UNITS, read_track_file
from ..floor.pushes import Cells, Kept, keep_pushes
from ..journal import Journal

Track = tuple[NDArray[np.float64], str]
Reads = Callable[[Path], Track]  # from a film's file to t_s, x_m, y_m in rows and its hash
TEXTS = (".csv", ".txt", ".tsv", ".dat")
QUESTION = "  its track (a file of Tracker, Kinovea or CSV; or a film), or how far it rolled (m): "


def no_films(path: Path) -> Track:
    """Refuse a film where nothing reads one."""
    raise BadInput(f"{path}: films are read by `serpenoid calibrate push DIR {path}`")


def named_file(text: str) -> tuple[Path, str] | None:
    """Return the file that was typed and the unit of its lengths, None if it names none."""
    words = text.strip().strip("'\"").split()
    unit = words.pop() if len(words) > 1 and words[-1] in UNITS else "m"
    path = Path(" ".join(words)).expanduser()
    return (path, unit) if path.is_file() or path.suffix.lower() in TEXTS else None


def read_track(path: Path, unit: str, films: Reads = no_films) -> Track:
    """Return the track of a file: a table of places, or a film; raises BadInput."""
    if not path.is_file():
        raise BadInput(f"{path}: no such file")
    return read_track_file(path, unit) if path.suffix.lower() in TEXTS else films(path)


def take_track(
    journal: Journal, path: Path, unit: str, cells: Cells, films: Reads = no_films
) -> list[Kept]:
    """Keep the pushes of a file; raises BadInput where there is none, or it was taken in before."""
    track, sha256 = read_track(path, unit, films)
    kept = journal.session.kept_pushes
    there = [p.number for p in kept if p.file_sha256 == sha256[:16]]
    if there:
        raise BadInput(f"{path}: reading {there[0]} is of this file already; it is not taken twice")
    return keep_pushes(journal, track, cells, file_sha256=sha256)
