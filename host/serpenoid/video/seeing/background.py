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
NEAR_PX = 2 * PATCH_PX + 1
REACH_PX = 1.0  # a point that is so far off the floor's common motion is somebody's foot


@dataclass
class Background:
    """Follow the floor's points. shifts: (time s, how far the floor at the robot moved, x y px)."""

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
        whole = np.ascontiguousarray(picture)
        self._first = _even(whole)
        self._points = cv2.goodFeaturesToTrack(
            whole, MOST_POINTS, 0.02, PATCH_PX, mask=free, blockSize=7
        )

    def _compare(self, time_s: float, picture: NDArray[np.uint8]) -> None:
        import cv2

        if self.plain:
            return
        assert self._first is not None
        assert self._points is not None
        found, status, _ = cv2.calcOpticalFlowPyrLK(  # type: ignore[call-overload]
            self._first,
            _even(np.ascontiguousarray(picture)),
            self._points,
            self._points.copy(),
            winSize=(PATCH_PX, PATCH_PX),
            maxLevel=4,
        )
        good = status.ravel() == 1
        if good.sum() < LEAST_POINTS:
            self.shifts.append((time_s, np.inf, np.inf))
            return
        way, _ = cv2.estimateAffinePartial2D(
            self._points[good], found[good], ransacReprojThreshold=REACH_PX
        )
        self.shifts.append((time_s, *self._farthest(way)))

    def _farthest(self, way: Any) -> tuple[float, float]:
        """Return by how much the corner of the robot's window moved that moved most, px.

        So a picture that turns or grows about its middle has moved, too.
        """
        if way is None:
            return np.inf, np.inf
        left, top, right, bottom = self.window
        corners = np.array([[x, y, 1.0] for x in (left, right) for y in (top, bottom)])
        moved = corners @ way.T - corners[:, :2]
        x, y = moved[np.argmax(np.linalg.norm(moved, axis=1))]
        return float(x), float(y)


def _even(picture: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return a picture divided by its own brightness nearby: lamps flicker, phones adapt."""
    import cv2

    near = cv2.blur(picture, (NEAR_PX, NEAR_PX))
    return np.asarray(cv2.divide(picture, near, scale=128), np.uint8)
