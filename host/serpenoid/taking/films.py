"""Files that answer a step: films, and tracks of pushes or crawls as tables."""

from __future__ import annotations

import os
from collections.abc import Callable
from os.path import isfile  # False, too, for what cannot be a name
from pathlib import Path

import numpy as np

from ..base.checks import sha256_of
from ..base.errors import BadInput
from ..base.files import csv_rows, read_text
from ..base.tables import OTHER_PROGRAMS
from ..base.toml_table import located
from ..model.capture_rate import OPTION, capture_rate, slow_motion_doubt
from ..model.gait import Gait
from ..model.robot import Robot
from ..session.declaration import LENGTH_UNITS, Cells
from ..session.filmed_crawl import crawl_cells
from ..session.gait_run import TRACK
from ..session.journal import Journal
from ..session.push import Push
from ..session.track import Track
from .pushes import keep_pushes
from .steps import Tracked
from .track_files import read_track_file

# A film to its track: of pushes, and cells of each push in it; or of a crawl, to cells of `video`.
FilmReader = Callable[[Path, Robot, Gait | None], Tracked]
TEXTS = (".csv", ".txt", ".tsv", ".dat")
FILMS = (".mp4", ".mov", ".mkv", ".avi", ".m4v", ".webm")


def named_file(text: str) -> tuple[Path, str | None] | None:
    """Return the file that was typed and the unit of its lengths, None if it names none."""
    name, _, last = text.strip().rpartition(" ")
    unit = last if name and last in LENGTH_UNITS else None
    path = Path(os.path.expanduser((name if unit else text).strip().strip("'\"")))
    suffixes = (*TEXTS, *FILMS, *OTHER_PROGRAMS)
    return (path, unit) if isfile(path) or path.suffix.lower() in suffixes else None


def no_films(path: Path, robot: Robot, gait: Gait | None) -> Tracked:
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
    tell: Callable[[str], object] = lambda text: None,
    capture_fps: float | None = None,
) -> list[Push]:
    """Keep the pushes of a file; raises BadInput where there is none, or it was taken in before.

    unit: of its lengths, where the file names none. film: what reads a film of the robot with tags,
    whose joints hold still. tell: is called with what a person should know of the file.
    capture_fps: pictures a second that the camera took, where a track was made of slow motion.
    """
    if path.suffix.lower() in (*TEXTS, *OTHER_PROGRAMS) or not isfile(path):
        table = read_track_file(path, unit)
        track, sha256 = table.values, table.sha256
        for note in table.notes:
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
    robot, sha256 = journal.session.setup.robot, sha256_of(path)
    for reading in journal.session.kept_films:
        if reading.film_sha256 == sha256:
            raise BadInput(f"{path}: reading {reading.number} is of this film already")
    if path.suffix.lower() not in TEXTS:
        return film(path, robot, gait)
    head, *lines = csv_rows(read_text(path), path)
    with located(str(path)):
        joints = len(head) - len(TRACK) + 1
        if tuple(head[:4]) != TRACK[:4] or joints != robot.links - 1:
            raise BadInput(
                f"its columns are {', '.join(head)}; give a track of {robot.links} links as "
                "`serpenoid video --track` writes it"
            )
        try:
            values = [[float(cell or "nan") for cell in line] for line in lines]
        except ValueError as error:
            raise BadInput(f"{error}; every cell must be a number") from None
        rows = Track.from_samples(TRACK, values).values
        return Tracked({**crawl_cells(rows, gait), "film_sha256": sha256}, rows, "video")
