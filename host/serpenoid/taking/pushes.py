"""Tracks of pushes taken into a session: cut into pushes, each looked at, all of them kept."""

from __future__ import annotations

from collections.abc import Sequence

from ..base.errors import BadInput
from ..session.declaration import Cells, Values
from ..session.journal import Journal
from ..session.push import TRACK, WAYS, Push
from ..session.rows import DOUBTFUL
from ..session.station import slips
from ..session.track import Floats, Track
from .track_look import Look, look_at, pushes_in


def keep_pushes(
    journal: Journal, track: Floats, cells: Cells, *, file_sha256: str = ""
) -> list[Push]:
    """Keep every push of a track, t_s, x_m, y_m in rows; return those readings.

    The first sound push goes the cells' way; the others there or back by where they go in the same
    picture. A push with a doubt is kept, too, but void: nothing measured is lost. file_sha256: of a
    file that a kill may have cut short: what it had kept is not kept twice, and tells the way.
    Raises BadInput where no push is, or all are there.
    """
    plan, links = journal.session.setup.plan, journal.session.setup.robot.links
    bend, lambda_deg = str(cells.get("bend", plan.bend)), float(cells.get("lambda_deg", 0.0))
    file = file_sha256[:16]
    looks = _looks(track, slips(bend, lambda_deg, links))
    hashes = [Track.from_samples(TRACK, rows).sha256 for rows, _ in looks]
    earlier = _pushes_of_file(journal, hashes, file)
    sound = (k for k, (_, look) in enumerate(looks) if not look.doubts)
    first = next((k for k, sha256 in enumerate(hashes) if sha256 in earlier), next(sound, 0))
    way = str(cells.get("way", WAYS[0]))
    if earlier:
        way = earlier[hashes[first]].way
    pushes = list[Push]()
    for (rows, look), sha256 in zip(looks, hashes, strict=True):
        if sha256 in earlier:
            continue
        same = float(look.way_m @ looks[first][1].way_m) >= 0.0
        values: Values = {**cells, **{k: round(v, 9) for k, v in look.cells.items()}}
        values |= {"way": way if same else other_way(way), "by": "film", "file_sha256": file}
        values |= {DOUBTFUL: "yes"} if look.doubts else {}
        journal.add("push", values, comment="; ".join(look.doubts), samples=rows)
        pushes.append(journal.session.readings_of("push")[-1])
    return pushes


def push_in_words(push: Push) -> str:
    """Return a push that was kept in a line, with what makes it void."""
    words = f"reading {push.number}, {': '.join(push.in_words())}"
    return f"{words}; VOID: {push.comment}" if push.voided else words


def other_way(way: str) -> str:
    """Return "back" for "there", and "there" for "back"."""
    return WAYS[1 - WAYS.index(way)]


def way_after(pushes: Sequence[Push], way: str) -> str:
    """Return the way of the next file's first push: the robot was turned round after the last.

    That one is the last sound push of this file; a void one if there is no other. way: where there
    was none.
    """
    ways = [push.way for push in pushes if not push.voided] or [push.way for push in pushes[:1]]
    return other_way(ways[-1]) if ways else way


def _pushes_of_file(journal: Journal, hashes: Sequence[str], file: str) -> dict[str, Push]:
    """Return the pushes of a file that are readings, by the hashes of their tracks.

    None where no push of it is in use. Raises BadInput unless a piece is left to take.
    """
    pushes = [
        push for push in journal.session.readings_of("push") if file and push.file_sha256 == file
    ]
    used = {push.track.sha256: push for push in pushes if not push.voided}
    if not used:
        return {}
    pushes_by_hash = {push.track.sha256: push for push in pushes}
    if set(used) - set(hashes) or set(hashes) <= set(pushes_by_hash):
        number = min(push.number for push in used.values())
        raise BadInput(f"reading {number} is of this file already; it is not taken twice")
    return pushes_by_hash


def _looks(track: Floats, slipping: bool) -> list[tuple[Floats, Look]]:
    """Return the pieces of a track that roll out, with what each shows; raises BadInput."""
    pieces = pushes_in(track)
    if not pieces:
        raise BadInput("nothing was pushed in this track: no place moves; is its unit right?")
    looks = []
    for piece in pieces:
        try:
            looks.append((piece, look_at(piece, slips=slipping)))
        except BadInput:
            if len(pieces) == 1:
                raise  # else a hand in the picture, nothing that rolls out
    return looks
