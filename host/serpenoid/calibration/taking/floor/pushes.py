"""Tracks of pushes taken into a session: cut into pushes, each looked at, all of them kept."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ....model.errors import BadInput
from ...floor.look import Look, look_at, pushes_in
from ...kinds.coast import WAYS
from ...kinds.tracks import Samples

Floats = NDArray[np.float64]
Cells = Mapping[str, float | str]


class Keeps(Protocol):
    """Where readings go: a journal, or memory."""

    def add(
        self, kind: str, cells: Cells, *, replaces: int = 0, comment: str = "",
        samples: Samples | None = None,
    ) -> int:  # fmt: skip
        """Keep a reading with its track; return its number."""
        ...

    def event(self, event: str, reading: int = 0, detail: str = "") -> None:
        """Keep an event."""
        ...


@dataclass(frozen=True)
class Kept:
    """One push that was kept: its number and what its track shows. doubts void it."""

    number: int
    look: Look
    way: str

    def in_words(self) -> str:
        """Return it in a line."""
        at = self.look
        told = (
            f"reading {self.number}, {self.way}: {at.way_m:.3f} m in {at.time_s:.2f} s from "
            f"{at.speed_m_s:.2f} m/s, places ± {1000 * at.sigma_m:.1f} mm"
        )
        if not at.doubts:
            return told
        return f"{told}; VOID: {'; '.join(at.doubts)} (`restore {self.number}` uses it)"


def keep_pushes(
    keeps: Keeps,
    track: Floats,
    cells: Cells,
    *,
    sigma_m: float | None = None,
    file_sha256: str = "",
) -> list[Kept]:
    """Keep every push of a track, t_s, x_m, y_m in rows.

    The first sound push goes the cells' way; the others there or back by where they go in the same
    picture. A push with a doubt is kept, too, but void: nothing measured is lost. sigma_m: of a
    place, where the instrument states it; else from the track's own scatter. Raises BadInput where
    no push is.
    """
    looked = _looked_at(track)
    if not looked:
        return []
    first = next((one for one in looked if not one[1].doubts), looked[0])
    found = []
    for rows, look in looked:
        same = float(_heading(rows, look) @ _heading(*first)) >= 0.0
        way = str(cells.get("way", WAYS[0]))
        one_way = dict(cells) | {"way": way if same else other_way(way)}
        found.append(_keep(keeps, rows, one_way, look, sigma_m, file_sha256))
    return found


def _looked_at(track: Floats) -> list[tuple[Floats, Look]]:
    """Return the pieces of a track that roll out, with what each shows; raises BadInput."""
    pieces = pushes_in(*track.T)
    if not pieces:
        raise BadInput("nothing was pushed in this track: no place moves; are lengths in metres?")
    looked = []
    for piece in pieces:
        try:
            looked.append((track[piece], look_at(*track[piece].T)))
        except BadInput:
            if len(pieces) == 1:
                raise  # else a hand in the picture, nothing that rolls out
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
    keeps: Keeps, rows: Floats, cells: dict[str, float | str], look: Look, sigma_m: float | None,
    file_sha256: str,
) -> Kept:  # fmt: skip
    told = {k: round(v, 9) for k, v in look.cells().items()}
    if sigma_m is not None:
        told["distance_sigma_m"] = max(sigma_m, told["distance_sigma_m"])
    whole = {**cells, **told, "by": "film", "file_sha256": file_sha256[:16]}
    number = keeps.add("coast", whole, samples=rows)
    if look.doubts:
        keeps.event("void", number, "; ".join(look.doubts))
    return Kept(number, look, str(cells["way"]))
