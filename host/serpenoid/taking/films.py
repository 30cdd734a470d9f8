"""Files that answer a step: films, and tracks of pushes as tables."""

from __future__ import annotations

import os
from collections.abc import Callable
from os.path import isfile  # False, too, for what cannot be a name
from pathlib import Path

import numpy as np

from ..base.checks import sha256_of
from ..base.errors import BadInput
from ..base.tables import OTHER_PROGRAMS
from ..base.toml_table import located
from ..model.capture_rate import OPTION, capture_rate, slow_motion_doubt
from ..model.gait import Gait
from ..model.robot import Robot
from ..session.declaration import LENGTH_UNITS, Cells
from ..session.journal import Journal
from ..session.push import Push
from .pushes import keep_pushes
from .steps import Tracked
from .track_files import read_track_file

# A film to its track: of pushes, and cells of each push in it; or of a crawl, to cells of `video`.
FilmReader = Callable[[Path, Robot, Gait | None], Tracked]
TEXTS = (".csv", ".txt", ".tsv", ".dat", *OTHER_PROGRAMS)


def named_file(text: str) -> tuple[Path, str | None] | None:
    """Return the file that was typed and the unit of its lengths, None if it names none."""
    name, _, last = text.strip().rpartition(" ")
    unit = last if name and last in LENGTH_UNITS else None
    path = Path(os.path.expanduser((name if unit else text).strip().strip("'\"")))
    return (path, unit) if isfile(path) or path.suffix[1:2].isalpha() else None


def no_films(path: Path, robot: Robot, gait: Gait | None) -> Tracked:
    """Refuse a film, where nothing is there to measure it."""
    raise BadInput(f"{path}: films are not measured here; give the track of a push")


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
    if path.suffix.lower() in TEXTS or not isfile(path):
        track, notes = read_track_file(path, unit)
        for note in notes:
            tell(note)
        if capture_fps is not None:
            rate = capture_rate(track[:, 0], capture_fps, OPTION)
            track = track * [rate.time_scale, 1.0, 1.0]
            tell(f"{path.name}: {rate.in_words()}")
        elif words := slow_motion_doubt(track[:, 0]):
            tell(f"{path.name}: {words}")
    else:
        filmed = film(path, journal.session.setup.robot, None)
        track, cells = np.array(filmed.samples, dtype=float), {**cells, **filmed}
    with located(str(path)):
        return keep_pushes(journal, track, cells, file_sha256=sha256_of(path))
