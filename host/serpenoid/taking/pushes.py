"""Tracks of pushes taken into a session: cut into pushes, each looked at, all of them readings."""

from __future__ import annotations

from ..base.errors import BadInput
from ..session.declaration import Cells, Values
from ..session.journal import Journal
from ..session.push import WAYS, Push
from ..session.rows import DOUBTFUL
from ..session.station import slips
from ..session.track import TRACK, Floats, Track
from .track_look import Look, look_at, pushes_in


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
