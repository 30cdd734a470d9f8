"""Tags in a frame: searched for in a window that follows the robot, else in the whole picture."""

from __future__ import annotations

from collections import Counter
from typing import Any

import numpy as np

from ..arrays import Array, Grey
from .edges import refine


def dictionary() -> Any:
    """Return the tags' dictionary: number 0 is the tail's."""
    import cv2

    return cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)


class TagFinder:
    """Find tags frame by frame; remembers where they were."""

    def __init__(self, links: int) -> None:
        self.links = links
        self.window: tuple[int, int, int, int] | None = None
        self.side_px = 0.0
        self.patience = 0
        self.strangers: Counter[int] = Counter()  # numbers that are on no link, and how often

    def find(self, picture: Grey) -> tuple[Array, Array]:
        """Return corners (links, 4, 2) and widths of edges (links,), px; NaN without a tag."""
        tags = np.full((self.links, 4, 2), np.nan), np.full(self.links, np.nan)
        if self.window:
            self._look(picture, *tags)
        visible = np.isfinite(tags[0][:, 0, 0])
        self.patience -= 1
        if visible.all():
            self.patience = 0
        elif not visible.any() or self.patience < 0:
            self.window, self.side_px = (0, 0, picture.shape[1], picture.shape[0]), 0.0
            self._look(picture, *tags)
            self.patience = 15  # frames until the whole picture is searched again
        self._follow(tags[0][np.isfinite(tags[0][:, 0, 0])], picture.shape)
        return tags

    def _look(self, picture: Grey, tags: Array, edge_px: Array) -> None:
        """Write the tags found in the window into two arrays, beside those that are there."""
        import cv2

        assert self.window is not None
        left_px, top, right, bottom = self.window
        part = np.ascontiguousarray(picture[top:bottom, left_px:right])
        p = cv2.aruco.DetectorParameters()
        p.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_CONTOUR
        p.minMarkerPerimeterRate = 0.01
        if self.side_px:
            window_px = int(np.clip(self.side_px * 0.8, 11, 101)) | 1
            p.adaptiveThreshWinSizeMin = window_px
            p.adaptiveThreshWinSizeMax = window_px
        corners, ids, _ = cv2.aruco.ArucoDetector(dictionary(), p).detectMarkers(part)
        if ids is None:
            return
        numbers = ids.ravel()
        quads, edges = refine(part, np.array([q.reshape(4, 2) for q in corners], float))
        self.strangers.update(numbers[numbers >= self.links].tolist())
        for link in np.flatnonzero(np.isnan(tags[:, 0, 0])):
            hits = quads[numbers == link]
            # A number that is seen at two places counts at neither: which is the robot's?
            if len(hits) and np.ptp(hits.mean(axis=1), axis=0).max() < 0.5 * np.ptp(hits[0, :, 0]):
                tags[link] = hits[-1] + [left_px, top]
                edge_px[link] = edges[numbers == link][-1]

    def _follow(self, quads: Array, shape: tuple[int, ...]) -> None:
        """Set the window for the next frame by the corners of the tags that were found."""
        if not len(quads):
            self.window = None
            return
        self.side_px = float(np.median(np.linalg.norm(quads[:, 1] - quads[:, 0], axis=1)))
        # Links that were not seen may be on either side: room for all of them.
        room = 2.5 * self.side_px * (1 + self.links - len(quads))
        ends = quads.min(axis=(0, 1)) - room, quads.max(axis=(0, 1)) + room + 1
        left_px, top, right, bottom = np.clip(ends, 0, shape[::-1]).astype(int).ravel().tolist()
        self.window = left_px, top, right, bottom
