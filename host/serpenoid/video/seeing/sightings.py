"""What the detector saw in a film: times, and the corners of every tag in every frame."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array, Mask, Places, Single


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
        corners_px = corners_px.astype(np.float32)
        places_px = corners_px.astype(float)
        rates = np.diff(places_px, axis=0) / np.diff(t_s)[:, None, None, None]
        padded = np.pad(rates, [(1, 1), (0, 0), (0, 0), (0, 0)], constant_values=np.nan)
        # How fast corners move: from both frames beside, or from the one that shows the tag.
        rate = np.ma.masked_invalid([padded[:-1], padded[1:]]).mean(axis=0)
        skew = np.ma.filled(rate * (places_px[..., 1:] / image_px[1] - 0.5), 0.0)
        return Sightings(t_s, corners_px, image_px, skew.astype(np.float32))

    @cached_property
    def visible(self) -> Mask:
        """Return which tags were found in which frame, (frames, links)."""
        return np.asarray(np.isfinite(self.corners_px).all(axis=(2, 3)))

    @property
    def links(self) -> int:
        """Return the number of links."""
        return self.corners_px.shape[1]

    def picked(self, frames: Places | Mask | slice) -> Sightings:
        """Return some frames of it."""
        return Sightings(
            self.t_s[frames], self.corners_px[frames], self.image_px, self.skew[frames]
        )

    @cached_property
    def side_px(self) -> Array:
        """Return the mean side of each tag, (frames, links), px; NaN where it was not found."""
        corners = self.corners_px.astype(float)
        edges = np.roll(corners, -1, axis=2) - corners
        return np.linalg.norm(edges, axis=-1).mean(axis=-1)
