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
from ..session.declaration import LENGTH_UNITS, Cells, Values
from ..session.folder import DOUBTFUL
from ..session.journal import Journal
from ..session.push import WAYS, Push
from ..session.station import slips
from ..session.track import TRACK, Floats, Track
from .steps import Tracked
from .track_files import read_track_file
from .track_look import Look, look_at, pushes_in

# A film to its track: of pushes, and cells of each push in it; or of a crawl, to cells of `video`.
FilmReader = Callable[[Path, Robot, Gait | None], Tracked]


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
    """Keep every push of a track, t_s, x_m, y_m in rows; return those readings.

    The first sound push goes the cells' way; the others there or back by where they go in the same
    picture. A push with a doubt is kept, too, but void: nothing measured is lost. file_sha256: of a
    file that a kill may have cut short: what it had kept is not kept twice, and tells the way.
    Raises BadInput where no push is, or all are there.
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
    """Return a push that was kept in a line, with what makes it void."""
    words = f"reading {push.number}, {': '.join(push.in_words())}"
    return f"{words}; VOID: {push.comment}" if push.voided else words


def other_way(way: str) -> str:
    """Return "back" for "there", and "there" for "back"."""
    return WAYS[1 - WAYS.index(way)]


def _pieces(track: Floats, slipping: bool) -> dict[str, tuple[Floats, Look]]:
    """Return the pieces of a track that roll out, by their hashes, with what each shows."""
    pieces = {}
    error = BadInput("nothing was pushed in this track: no place moves; is its unit right?")
    for rows in pushes_in(track):
        try:
            pieces[Track.from_samples(TRACK, rows).sha256] = rows, look_at(rows, slips=slipping)
        except BadInput as reason:  # a hand in the picture, nothing that rolls out
            error = reason
    if not pieces:
        raise error
    return pieces
