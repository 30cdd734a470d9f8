"""What the detector saw in a film: times, and the corners of every tag in every frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Sightings:
    """Hold the corners that were found.

    t_s: (frames,) the file's time of each frame. corners_px: (frames, links, 4, 2), NaN where a
    tag was not found; the tag of link 1, the tail, first. image_px: width and height. skew:
    (frames, links, 4, 2), how far a corner moves for each second of readout time, px/s.
    """

    t_s: Array
    corners_px: Array
    image_px: tuple[int, int]
    skew: Array

    @staticmethod
    def of(t_s: Array, corners_px: Array, image_px: tuple[int, int]) -> Sightings:
        """Return sightings; a row's time is off by its share of the readout, about the middle."""
        row = corners_px[..., 1:] / image_px[1] - 0.5
        skew = row * _velocity(t_s, corners_px)
        return Sightings(t_s, corners_px, image_px, np.where(np.isfinite(skew), skew, 0.0))

    @property
    def seen(self) -> NDArray[np.bool_]:
        """Return which tags were found in which frame, (frames, links)."""
        return np.asarray(np.isfinite(self.corners_px).all(axis=(2, 3)))

    @property
    def links(self) -> int:
        """Return the number of links."""
        return self.corners_px.shape[1]

    def picked(self, frames: NDArray[np.int64] | NDArray[np.bool_] | slice) -> Sightings:
        """Return some frames of it."""
        return Sightings(
            self.t_s[frames], self.corners_px[frames], self.image_px, self.skew[frames]
        )

    @property
    def side_px(self) -> Array:
        """Return the mean side of each tag, (frames, links), px; NaN where it was not found."""
        sides = np.roll(self.corners_px, -1, axis=2) - self.corners_px
        return np.linalg.norm(sides, axis=-1).mean(axis=-1)


def _velocity(t_s: Array, corners_px: Array) -> Array:
    """Return how fast corners move, px/s: from the frames beside, or from the one that has it."""
    apart = np.diff(corners_px, axis=0) / np.diff(t_s)[:, None, None, None]
    none = np.full((1, *corners_px.shape[1:]), np.nan)
    before, after = np.concatenate([none, apart]), np.concatenate([apart, none])
    both = 0.5 * (before + after)
    one = np.where(np.isfinite(before), before, after)
    return np.where(np.isfinite(both), both, one)
