"""A film watched once from its first frame to its last: tags, edges, floor, times."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ...base.errors import BadInput
from ..arrays import Grey, Single
from .background import Background
from .detect import TagFinder
from .film import Film
from .sightings import Sightings


@dataclass(frozen=True)
class Watched:
    """What one look at a film brought up.

    film; sightings; edge_px (frames, links): width of a tag's edges, NaN where none; strangers:
    tags of numbers that are on no link, with the number of frames; shifts: of the floor, (time,
    x px, y px, sigma px); plain_floor: too little on it can be followed; picture: the first frame
    with a tag, grey.
    """

    film: Film
    sightings: Sightings
    edge_px: Single
    strangers: Counter[int]
    shifts: tuple[tuple[float, float, float, float], ...]
    plain_floor: bool
    picture: Grey


def watch(film: Film, links: int, progress: Callable[[float], object] = lambda _: None) -> Watched:
    """Read a film. progress: called with the share of it that is read. Raises BadInput."""
    finder = TagFinder(links)
    looks: list[tuple[float, Single, Single]] = []
    ground: Background | None = None
    picture: Grey = np.empty((0, 0), np.uint8)
    for time_s, grey in film.frames():
        tags = finder.find(grey)
        corners = np.full((links, 4, 2), np.nan, np.float32)
        width = np.full(links, np.nan, np.float32)
        for link, (quad, edge_px) in tags.items():
            corners[link], width[link] = quad, edge_px
        looks.append((time_s, corners, width))
        if ground is not None:
            ground.look(time_s, grey)
        elif tags and finder.window:
            picture, ground = grey.copy(), Background(finder.window, time_s, grey)
        progress(time_s / max(film.duration_s, 1.0))
    if not looks:
        raise BadInput(f"{film.path}: not one frame can be read; copy it again")
    times_s, corners_px, edge_px = map(np.array, zip(*looks, strict=True))
    sharp_px = _sharp(corners_px, edge_px)
    sightings = Sightings.from_corners(times_s, sharp_px, (film.width, film.height))
    shifts, plain = (tuple(ground.shifts), ground.plain) if ground is not None else ((), True)
    return Watched(
        film,
        sightings,
        edge_px,
        finder.strangers,
        shifts,
        plain,
        picture,
    )


def _sharp(corners_px: Single, edge_px: Single) -> Single:
    """Leave out, in place, tags whose edges could not be read, where nearly all could."""
    visible = np.isfinite(corners_px[..., 0, 0])
    coarse = visible & ~np.isfinite(edge_px)
    if coarse.sum() <= 0.2 * visible.sum():
        corners_px[coarse] = np.nan
    return corners_px
