"""Tags in a frame: searched for in a window that follows the robot, else in the whole picture."""

from __future__ import annotations

from collections import Counter
from typing import Any

import numpy as np

from ..arrays import Array, Grey
from .edges import refine

Tag = tuple[Array, float]  # corners (4, 2) px, clockwise; width of the edges, px


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

    def find(self, picture: Grey) -> dict[int, Tag]:
        """Return the tags found, by link from 0."""
        tags = self._look(picture) if self.window else {}
        if len(tags) == self.links:
            self.patience = 0
        elif not tags or self.patience <= 0:
            self.window, self.side_px = (0, 0, picture.shape[1], picture.shape[0]), 0.0
            tags = self._look(picture) | tags
            self.patience = 15  # frames until the whole picture is searched again
        else:
            self.patience -= 1
        self._follow(tags, picture.shape)
        return tags

    def _look(self, picture: Grey) -> dict[int, Tag]:
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
            return {}
        numbers = ids.ravel()
        quads, edges = refine(part, np.array([q.reshape(4, 2) for q in corners], float))
        self.strangers.update(numbers[numbers >= self.links].tolist())
        tags: dict[int, Tag] = {}
        for link in range(self.links):
            hits = quads[numbers == link]
            # A number that is seen at two places counts at neither: which is the robot's?
            if len(hits) and np.ptp(hits.mean(axis=1), axis=0).max() < 0.5 * np.ptp(hits[0, :, 0]):
                edge_px = float(edges[numbers == link][-1])
                tags[link] = hits[-1] + [left_px, top], edge_px
        return tags

    def _follow(self, tags: dict[int, Tag], shape: tuple[int, ...]) -> None:
        """Set the window for the next frame."""
        if not tags:
            self.window = None
            return
        quads = np.array([quad for quad, _ in tags.values()])
        self.side_px = float(np.median(np.linalg.norm(quads[:, 1] - quads[:, 0], axis=1)))
        # Links that were not seen may be on either side: room for all of them.
        room = 2.5 * self.side_px * (1 + self.links - len(tags))
        ends = quads.min(axis=(0, 1)) - room, quads.max(axis=(0, 1)) + room + 1
        left_px, top, right, bottom = np.clip(ends, 0, shape[::-1]).astype(int).ravel().tolist()
        self.window = left_px, top, right, bottom
