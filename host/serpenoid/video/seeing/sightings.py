"""What the detector saw in a film: times, and the corners of every tag in every frame."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array, Mask, Places, Single

CHUNK = 400  # frames at once: memory stays small however long the film


@dataclass(frozen=True)
class Sightings:
    """Hold the corners that were found.

    t_s: (frames,) the file's time of each frame. corners_px: (frames, links, 4, 2), NaN where a
    tag was not found; the tag of link 1, the tail, first. image_px: width and height. skew:
    (frames, links, 4, 2), how far a corner moves for each second of readout time, px/s.
    """

    t_s: Array
    corners_px: Single
    image_px: tuple[int, int]
    skew: Single

    @staticmethod
    def from_corners(t_s: Array, corners_px: NDArray[Any], image_px: tuple[int, int]) -> Sightings:
        """Return sightings; a row's time is off by its share of the readout, about the middle."""
        corners_px = corners_px.astype(np.float32, copy=False)

        def skews(cut: slice) -> tuple[Single]:
            begin = max(0, cut.start - 1)
            neighbours = slice(begin, cut.stop + 1)
            near_px = corners_px[neighbours].astype(float)
            row = near_px[..., 1:] / image_px[1] - 0.5
            # how fast corners move: from the frames beside, or from the one that has it
            rates = np.diff(near_px, axis=0) / np.diff(t_s[neighbours])[:, None, None, None]
            gap = np.full((1, *near_px.shape[1:]), np.nan)
            backward, forward = np.concatenate([gap, rates]), np.concatenate([rates, gap])
            one_sided, central = (
                np.where(np.isfinite(backward), backward, forward),
                0.5 * (backward + forward),
            )
            row_shift = row * np.where(np.isfinite(central), central, one_sided)
            skew = np.where(np.isfinite(row_shift), row_shift, 0.0).astype(np.float32)
            return (skew[cut.start - begin :][:CHUNK],)

        return Sightings(t_s, corners_px, image_px, in_chunks(skews, len(t_s))[0])

    @cached_property
    def visible(self) -> Mask:
        """Return which tags were found in which frame, (frames, links)."""
        return np.asarray(np.isfinite(self.corners_px).all(axis=(2, 3)))

    @property
    def links(self) -> int:
        """Return the number of links."""
        return self.corners_px.shape[1]

    def picked(self, frames: Places | Mask | slice) -> Sightings:
        """Return some frames of it; the same sightings where a mask picks all."""
        if isinstance(frames, np.ndarray) and frames.dtype == bool and frames.all():
            return self
        return Sightings(
            self.t_s[frames], self.corners_px[frames], self.image_px, self.skew[frames]
        )

    @cached_property
    def side_px(self) -> Array:
        """Return the mean side of each tag, (frames, links), px; NaN where it was not found."""

        def sides(cut: slice) -> tuple[Array]:
            corners = self.corners_px[cut].astype(float)
            apart = np.roll(corners, -1, axis=2) - corners
            return (np.linalg.norm(apart, axis=-1).mean(axis=-1),)

        return in_chunks(sides, len(self.t_s))[0]


def in_chunks(
    function: Callable[[slice], tuple[NDArray[Any], ...]], frames: int
) -> list[NDArray[Any]]:
    """Return a function's arrays (frames, ...), which it makes for some frames at a time."""
    parts = [function(slice(first, first + CHUNK)) for first in range(0, max(1, frames), CHUNK)]
    return [np.concatenate(part) for part in zip(*parts, strict=True)]
