"""Take pushes from files: films of the robot, and tables of its track."""

from __future__ import annotations

import os
from collections.abc import Callable
from os.path import isfile  # It is False, without an error, for text that cannot be a path.
from pathlib import Path

import numpy as np

from ..base.checks import sha256_of
from ..base.errors import BadInput
from ..base.tables import OTHER_PROGRAMS
from ..base.toml_table import located
from ..model.capture_rate import OPTION, capture_rate, slow_motion_doubt
from ..model.gait import Gait
from ..model.robot import Robot
from ..session.declaration import LENGTH_UNITS, Cells, Values
from ..session.folder import DOUBTFUL
from ..session.journal import Journal
from ..session.push import WAYS, Push
from ..session.station import slips
from ..session.track import TRACK, Floats, Track
from .procedure import Tracked
from .track_files import read_track_file
from .track_look import Look, look_at, pushes_in

# Function of a film, the robot and the commanded gait (None: the film shows pushes). It returns the
# cells of the reading, with the samples of its track.
FilmReader = Callable[[Path, Robot, Gait | None], Tracked]


def named_file(text: str) -> tuple[Path, str | None] | None:
    """Return the file in a typed line, and the unit of its lengths if there is one.

    The result is None if the line names no file.
    """
    name, _, last = text.strip().rpartition(" ")
    unit = last if name and last in LENGTH_UNITS else None
    path = Path(os.path.expanduser((name if unit else text).strip().strip("'\"")))
    return (path, unit) if isfile(path) or path.suffix[1:2].isalpha() else None


def take_track(
    journal: Journal,
    path: Path,
    unit: str | None,
    cells: Cells,
    film: FilmReader,
    tell: Callable[[str], object],
    capture_fps: float | None = None,
) -> list[Push]:
    """Add the pushes of a film or table to the journal; return these readings.

    unit: unit of the table's lengths, if the table has none. cells: columns of the readings.
    film: reader of films. tell: called with each note on the file for the person. capture_fps:
    frames a second at which the camera recorded slow motion, Hz. Raises BadInput if the file has no
    push, or if all its pushes are there.
    """
    if path.suffix.lower() in (".csv", ".txt", ".tsv", ".dat", *OTHER_PROGRAMS) or not isfile(path):
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


def keep_pushes(journal: Journal, track: Floats, cells: Cells, *, file_sha256: str) -> list[Push]:
    """Add the pushes of a track, (rows, 3) with t_s, x_m, y_m, to the journal; return the readings.

    The first sound push has the direction in cells; the others are forward or backward by their
    displacement relative to it. A doubtful push is added as void, so that no measurement is lost.
    file_sha256: hash of the file. Pushes that an interrupted run has added from it are not added
    again, and determine the direction. Raises BadInput if there is no push, or no new one.
    """
    setup, file = journal.session.setup, file_sha256[:16]
    lambda_deg = float(cells.get("lambda_deg", 0.0))
    pieces = _pieces(track, slips(setup.plan.bend, lambda_deg, setup.robot.links))
    pushes = [push for push in journal.session.kept_pushes if push.file_sha256 == file]
    used = {push.track.sha256: push for push in pushes if push.track}
    new = [sha256 for sha256 in pieces if sha256 not in used]
    sound_pushes = [sha256 for sha256 in new if not pieces[sha256][1].doubts]
    if used and not (sound_pushes and used.keys() <= pieces.keys()):
        number = min(push.number for push in used.values())
        raise BadInput(f"reading {number} is of this file already")
    first = [*used, *sound_pushes, *new][0]
    way = used[first].way if used else str(cells.get("way", WAYS[0]))
    for sha256 in new:
        rows, look = pieces[sha256]
        same = float(look.way_m @ pieces[first][1].way_m) >= 0.0
        values: Values = {**cells, **look.cells, "by": "film", "file_sha256": file}
        values |= {"way": way if same else other_way(way)}
        values |= {DOUBTFUL: "yes"} if look.doubts else {}
        journal.add("push", values, comment="; ".join(look.doubts), samples=rows)
    return list(journal.session.readings_of("push")[-len(new) :])


def push_in_words(push: Push) -> str:
    """Return a line on a push, with the reason if it is void."""
    words = f"reading {push.number}, {': '.join(push.in_words())}"
    return f"{words}; VOID: {push.comment}" if push.voided else words


def other_way(way: str) -> str:
    """Return "back" for "there", and "there" for "back"."""
    return WAYS[1 - WAYS.index(way)]


def _pieces(track: Floats, slipping: bool) -> dict[str, tuple[Floats, Look]]:
    """Return the pieces of a track in which the robot rolls to a stop, hash -> (samples, look)."""
    pieces = {}
    error = BadInput("nothing was pushed in this track: no place moves; is its unit right?")
    for rows in pushes_in(track):
        try:
            pieces[Track.from_samples(TRACK, rows).sha256] = rows, look_at(rows, slips=slipping)
        except BadInput as reason:  # For instance a hand in the picture, without a push.
            error = reason
    if not pieces:
        raise error
    return pieces
