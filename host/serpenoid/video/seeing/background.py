"""Whether the camera stood still: points of the floor, followed from the first frame on."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
EVERY_S = 0.5
MOST_POINTS, LEAST_POINTS = 150, 12
PATCH_PX = 21


@dataclass
class Background:
    """Follow the floor's points. shifts: (time s, how far they moved, px, in the median)."""

    window: tuple[int, int, int, int]
    shifts: list[tuple[float, float, float]] = field(default_factory=list)
    _first: NDArray[np.uint8] | None = None
    _points: Any = None  # (points, 1, 2) float32
    _next_s: float = 0.0

    def look(self, time_s: float, picture: NDArray[np.uint8]) -> None:
        """Take a frame; most are passed over."""
        if self._first is None:
            self._start(picture)
            self._next_s = time_s + EVERY_S
        elif time_s >= self._next_s:
            self._next_s = time_s + EVERY_S
            self._compare(time_s, picture)

    @property
    def plain(self) -> bool:
        """Tell whether the floor shows too little to follow."""
        return self._points is None or len(self._points) < LEAST_POINTS

    def _start(self, picture: NDArray[np.uint8]) -> None:
        import cv2

        free = np.full(picture.shape, 255, np.uint8)
        left, top, right, bottom = self.window
        free[top:bottom, left:right] = 0
        self._first = np.ascontiguousarray(picture)
        self._points = cv2.goodFeaturesToTrack(
            self._first, MOST_POINTS, 0.02, PATCH_PX, mask=free, blockSize=7
        )

    def _compare(self, time_s: float, picture: NDArray[np.uint8]) -> None:
        import cv2

        if self.plain:
            return
        assert self._first is not None
        assert self._points is not None
        found, status, _ = cv2.calcOpticalFlowPyrLK(  # type: ignore[call-overload]
            self._first,
            np.ascontiguousarray(picture),
            self._points,
            self._points.copy(),
            winSize=(PATCH_PX, PATCH_PX),
            maxLevel=4,
        )
        good = status.ravel() == 1
        if good.sum() < LEAST_POINTS:
            self.shifts.append((time_s, np.inf, np.inf))
            return
        moved = (found - self._points)[good].reshape(-1, 2)
        x, y = np.median(moved, axis=0)
        self.shifts.append((time_s, float(x), float(y)))
