"""What the dialogue asks after a push: a file of its track, or way and time by tape and watch."""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from os.path import isfile  # False, too, for what cannot be a name
from pathlib import Path

import numpy as np

from ..base.checks import sha256_of
from ..base.errors import BadInput
from ..base.tables import EMPTY_CELLS, OTHER_PROGRAMS, columns_named, read_table
from ..base.toml_table import located
from ..model.capture_rate import OPTION, capture_rate, slow_motion_doubt
from ..model.gait import Gait
from ..model.robot import Robot
from ..session.declaration import LENGTH_UNITS, Cells
from ..session.filmed_crawl import crawl_cells
from ..session.journal import Journal
from ..session.track import Floats
from .pushes import Kept, keep_pushes
from .steps import Tracked
from .track_files import read_track_file

# A film to its track: of pushes, and cells of each push in it; or of a crawl, to cells of `video`.
FilmReader = Callable[[Path, Robot, Gait | None], Tracked]
TEXTS = (".csv", ".txt", ".tsv", ".dat")
FILMS = (".mp4", ".mov", ".mkv", ".avi", ".m4v", ".webm")
CRAWL_COLUMNS = ("t_s", "x_m", "y_m", "heading_rad")  # of `video --track`; then the joints


def named_file(text: str) -> tuple[Path, str | None] | None:
    """Return the file that was typed and the unit of its lengths, None if it names none."""
    name, _, last = text.strip().rpartition(" ")
    unit = last if name and last in LENGTH_UNITS else None
    path = Path(os.path.expanduser((name if unit else text).strip().strip("'\"")))
    known = (*TEXTS, *FILMS, *OTHER_PROGRAMS)
    return (path, unit) if isfile(path) or path.suffix.lower() in known else None


def no_words(text: str) -> None:
    """Tell nobody."""


def no_films(path: Path, *given: object) -> Tracked:
    """Refuse a film, where nothing is there to measure it."""
    raise BadInput(
        f"{path}: a film itself is not taken here; give the track of the robot's middle link that "
        "Tracker or Kinovea exports; or of a crawl, what `serpenoid video FILE --track crawl.csv` "
        "writes with the gait's options"
    )


def take_track(
    journal: Journal,
    path: Path,
    unit: str | None,
    cells: Cells,
    film: FilmReader = no_films,
    tell: Callable[[str], object] = no_words,
    capture_fps: float | None = None,
) -> list[Kept]:
    """Keep the pushes of a file; raises BadInput where there is none, or it was taken in before.

    unit: of its lengths, where the file names none. film: what reads a film of the robot with tags,
    whose joints hold still. tell: is called with what a person should know of the file.
    capture_fps: pictures a second that the camera took, where a track was made of slow motion.
    """
    if path.suffix.lower() in (*TEXTS, *OTHER_PROGRAMS) or not isfile(path):
        found = read_track_file(path, unit)
        track, sha256 = found.values, found.sha256
        for note in found.notes:
            tell(note)
        if capture_fps is not None:
            rate = capture_rate(track[:, 0], capture_fps, OPTION)
            track = track * [rate.time_scale, 1.0, 1.0]
            tell(f"{path.name}: {rate.in_words()}")
        elif words := slow_motion_doubt(track[:, 0]):
            tell(f"{path.name}: {words}")
    else:
        sha256 = sha256_of(path)
        filmed = film(path, journal.session.setup.robot, None)
        track, cells = np.array(filmed.samples, dtype=float), {**cells, **filmed}
    with located(str(path)):
        return keep_pushes(journal, track, cells, file_sha256=sha256)


def read_crawl(journal: Journal, path: Path, gait: Gait, film: FilmReader = no_films) -> Tracked:
    """Return the `video` reading of a film of a crawl, or of its track; raises BadInput.

    A track is a CSV file as `serpenoid video --track` writes it.
    """
    if not isfile(path):
        raise BadInput(f"{path}: no such file")
    sha256 = sha256_of(path)
    for taken in journal.session.kept_films:
        if taken.film_sha256 == sha256:
            raise BadInput(f"{path}: reading {taken.number} is of this film already")
    if path.suffix.lower() not in TEXTS:
        return film(path, journal.session.setup.robot, gait)
    rows = _crawl_rows(path, journal.session.setup.robot.links - 1)
    return Tracked({**crawl_cells(rows, gait), "film_sha256": sha256}, rows, "video")


def joint_columns(joints: int) -> list[str]:
    """Return the names of the joints' columns."""
    return [f"joint{k + 1}_rad" for k in range(joints)]


def _crawl_rows(path: Path, joints: int) -> Floats:
    names = [*CRAWL_COLUMNS, *joint_columns(joints)]
    table, places = read_table(
        path, columns_named(*names), f"{','.join(names)}, as `serpenoid video --track` writes them"
    )
    rows: list[list[float]] = []
    for line, cells in table.rows:
        if not any(cells):
            continue
        texts = [cells[place] if place < len(cells) else "" for place in places]
        try:
            rows.append([math.nan if text in EMPTY_CELLS else table.number(text) for text in texts])
        except ValueError as error:
            raise BadInput(f"{table.where(line)}: {error}; every cell must be a number") from None
        if not all(map(math.isfinite, rows[-1][: len(CRAWL_COLUMNS)])):
            raise BadInput(f"{table.where(line)}: a cell is empty; joints alone may be empty")
    return np.array(rows, dtype=float).reshape(len(rows), len(names))
