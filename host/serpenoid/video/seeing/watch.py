"""A film watched once from its first frame to its last: tags, edges, floor, times."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ...base.errors import BadInput
from ..arrays import Single
from .background import Background
from .detect import TagFinder
from .film import Film
from .sightings import Sightings


@dataclass(frozen=True)
class Watched:
    """What one look at a film brought up.

    film; sightings; edge_px (frames, links): width of a tag's edges, NaN where none; strangers:
    tags of numbers that are on no link, with the number of frames; ground: the floor.
    """

    film: Film
    sightings: Sightings
    edge_px: Single
    strangers: Counter[int]
    ground: Background


def watch(film: Film, links: int, progress: Callable[[float], object]) -> Watched:
    """Read a film. progress: called with the share of it that is read. Raises BadInput."""
    finder, ground, frames = TagFinder(links), Background(), []
    for time_s, picture in film.frames():
        frames.append((time_s, *finder.find(picture)))
        ground.look(time_s, picture, finder.window)
        progress(time_s / max(film.duration_s, 1.0))
    if not frames:
        raise BadInput(f"{film.path}: not one frame can be read; copy it again")
    times_s, corners_px, edge_px = map(np.array, zip(*frames, strict=True))
    # Tags whose edges could not be read are left out where nearly all could.
    visible = np.isfinite(corners_px[..., 0, 0])
    coarse = visible & ~np.isfinite(edge_px)
    if coarse.sum() <= 0.2 * visible.sum():
        corners_px[coarse] = np.nan
    sightings = Sightings.from_corners(times_s, corners_px, (film.width, film.height))
    return Watched(film, sightings, edge_px.astype(np.float32), finder.strangers, ground)
