"""Tracks of pushes taken into a session: cut into pushes, each looked at, all of them kept."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ..base.errors import BadInput
from ..session.declaration import Cells, Values
from ..session.journal import Journal
from ..session.push import TRACK, WAYS, Push, unlikely_push
from ..session.rows import DOUBTFUL
from ..session.station import slips
from ..session.track import Floats, Track
from .track_look import Look, look_at, pushes_in


@dataclass(frozen=True)
class Kept:
    """One push that was kept: its number and what its track shows. doubts void it."""

    number: int
    look: Look
    way: str

    def in_words(self) -> str:
        """Return it in a line."""
        look = self.look
        words = (
            f"reading {self.number}, {self.way}: {look.way_m:.3f} m in {look.time_s:.2f} s from "
            f"{look.speed_m_s:.2f} m/s, places ± {1000 * look.sigma_m:.1f} mm"
        )
        if not look.doubts:
            return words
        return f"{words}; VOID: {'; '.join(look.doubts)}"


def keep_pushes(
    journal: Journal,
    track: Floats,
    cells: Cells,
    *,
    file_sha256: str = "",
) -> list[Kept]:
    """Keep every push of a track, t_s, x_m, y_m in rows.

    The first sound push goes the cells' way; the others there or back by where they go in the same
    picture. A push with a doubt is kept, too, but void: nothing measured is lost. file_sha256: of a
    file that a kill may have cut short: what it had kept is not kept twice, and tells the way.
    Raises BadInput where no push is, or all are there.
    """
    plan, links = journal.session.setup.plan, journal.session.setup.robot.links
    bend, lambda_deg = str(cells.get("bend", plan.bend)), float(cells.get("lambda_deg", 0.0))
    looked = _looked_at(track, slips(bend, lambda_deg, links))
    if not looked:
        return []
    there = _there(journal, [rows for rows, _ in looked], file_sha256)
    first = next((k for k, (_, look) in enumerate(looked) if not look.doubts), 0)
    anchor = min(there, default=first)
    way = there[anchor].way if there else str(cells.get("way", WAYS[0]))
    kept = []
    for k, (rows, look) in enumerate(looked):
        if k not in there:
            same = float(_heading(rows, look) @ _heading(*looked[anchor])) >= 0.0
            one_way = dict(cells) | {"way": way if same else other_way(way)}
            kept.append(_keep(journal, rows, one_way, look, file_sha256))
    return kept


def _there(journal: Journal, pieces: Sequence[Floats], file_sha256: str) -> dict[int, Push]:
    """Return which pieces of a file are readings; none where no push of it is in use.

    Raises BadInput unless a piece is left to take.
    """
    taken = [p for p in journal.session.of("push") if p.file_sha256 == file_sha256[:16] != ""]
    used = [p for p in taken if not p.voided]
    if not used:
        return {}
    known = {p.track.sha256: p for p in taken if p.track is not None}
    hashes = [Track.from_samples(TRACK, rows).sha256 for rows in pieces]
    other = any(p.track is None or p.track.sha256 not in hashes for p in used)
    if other or all(sha256 in known for sha256 in hashes):
        raise BadInput(f"reading {used[0].number} is of this file already; it is not taken twice")
    return {k: known[sha256] for k, sha256 in enumerate(hashes) if sha256 in known}


def _looked_at(track: Floats, slipping: bool) -> list[tuple[Floats, Look]]:
    """Return the pieces of a track that roll out, with what each shows; raises BadInput."""
    pieces = pushes_in(*track.T)
    if not pieces:
        raise BadInput("nothing was pushed in this track: no place moves; is its unit right?")
    looked = []
    for piece in pieces:
        try:
            looked.append((track[piece], look_at(*track[piece].T, slips=slipping)))
        except BadInput:
            if len(pieces) == 1:
                raise  # else a hand in the picture, nothing that rolls out
    for _, look in looked:
        if not look.doubts and (told := unlikely_push(look.speed_m_s, look.way_m)):
            raise BadInput(f"{told}; is the scale right (--unit of a table, --tag-mm of a film)?")
    return looked


def _heading(rows: Floats, look: Look) -> Floats:
    """Return where a push goes, m: from where it was let go to where it rests."""
    counted = rows[(rows[:, 0] >= look.start_s) & (rows[:, 0] <= look.end_s)]
    return counted[-1, 1:] - counted[0, 1:]  # type: ignore[no-any-return]


def other_way(way: str) -> str:
    """Return "back" for "there", and "there" for "back"."""
    return WAYS[1 - WAYS.index(way)]


def way_after(kept: Sequence[Kept], way: str) -> str:
    """Return the way of the next file's first push: the robot was turned round after the last.

    That one is the last sound push of this file; a void one if there is no other. way: where none
    was found.
    """
    last = [k.way for k in kept if not k.look.doubts] or [k.way for k in kept[:1]]
    return other_way(last[-1]) if last else way


def _keep(
    journal: Journal,
    rows: Floats,
    cells: Values,
    look: Look,
    file_sha256: str,
) -> Kept:
    told = {k: round(v, 9) for k, v in look.cells().items()}
    whole = {**cells, **told, "by": "film", "file_sha256": file_sha256[:16]}
    whole |= {DOUBTFUL: "yes"} if look.doubts else {}
    number = journal.add("push", whole, comment="; ".join(look.doubts), samples=rows)
    return Kept(number, look, str(cells["way"]))
