"""Whether the camera stood still: points of the floor, followed from the first frame on."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..arrays import Array, Grey

EVERY_S = 0.5
MOST_POINTS, LEAST_POINTS = 150, 12
PATCH_PX = 21
NEAR_PX = 2 * PATCH_PX + 1
REACH_PX = 1.0  # a point that is so far off the floor's common motion is somebody's foot


class Background:
    """Follow the floor's points from the first frame to a later one, and back again.

    A point counts where it comes back to its place, and where it goes with most others: noise does
    neither. shifts: (time s, how far the floor at the robot moved, x y px, and the standard
    deviation of that), of the looks in which enough points count. looks: all of them.
    """

    def __init__(self, window: tuple[int, int, int, int], time_s: float, picture: Grey) -> None:
        """Take the first frame; window: where the robot is, left, top, right, bottom, px."""
        import cv2

        self.window = window
        self.shifts: list[tuple[float, float, float, float]] = []
        self.looks = 0
        self._next_s = time_s + EVERY_S
        free = np.full(picture.shape, 255, np.uint8)
        left, top, right, bottom = window
        free[top:bottom, left:right] = 0
        whole = np.ascontiguousarray(picture)
        self._first = _even(whole)
        self._points: Any = cv2.goodFeaturesToTrack(  # (points, 1, 2) float32
            whole, MOST_POINTS, 0.02, PATCH_PX, mask=free, blockSize=7
        )

    @property
    def plain(self) -> bool:
        """Tell whether the floor shows too little to follow."""
        return len(self.shifts) <= self.looks / 2

    def look(self, time_s: float, picture: Grey) -> None:
        """Take a later frame; most are passed over."""
        import cv2

        if time_s < self._next_s:
            return
        self._next_s = time_s + EVERY_S
        self.looks += 1
        if self._points is None:
            return
        later = _even(np.ascontiguousarray(picture))
        forward_points, status = self._follow(self._first, later, self._points)
        returned_points, returned_status = self._follow(later, self._first, forward_points)
        distance = np.linalg.norm(returned_points - self._points, axis=2).ravel()
        is_good = (status & returned_status).ravel() == 1
        is_good &= distance < REACH_PX
        if is_good.sum() < max(LEAST_POINTS, len(is_good) / 3):
            return
        start, end = self._points[is_good, 0], forward_points[is_good, 0]
        _, inliers = cv2.estimateAffinePartial2D(start, end, ransacReprojThreshold=REACH_PX)
        is_common = inliers.ravel() == 1
        if is_common.sum() >= max(LEAST_POINTS, is_good.sum() / 2):
            points, shifts = start[is_common], (end - start)[is_common]
            # The picture moves, turns and grows: by how much did the window's corner move that
            # moved most? So a picture that turns or grows about its middle has moved, too.
            left, top, right, bottom = self.window
            ends = [[left, top], [left, bottom], [right, top], [right, bottom]]
            corners = np.array(ends, float)
            a, corner_rows = _similar(points), _similar(corners)
            inverse = np.linalg.inv(a.T @ a)
            motion = inverse @ a.T @ shifts.ravel()
            spread = np.sum((shifts.ravel() - a @ motion) ** 2) / (a.shape[0] - 4)
            shift = (corner_rows @ motion).reshape(-1, 2)
            worst = int(np.argmax(np.linalg.norm(shift, axis=1)))
            rows = corner_rows[2 * worst : 2 * worst + 2]
            sigma = np.sqrt(spread * np.trace(rows @ inverse @ rows.T) / 2)
            x, y = shift[worst].tolist()
            self.shifts.append((time_s, x, y, float(sigma)))

    @staticmethod
    def _follow(first: Any, other: Any, points: Any) -> tuple[Any, Any]:
        import cv2

        size = (PATCH_PX, PATCH_PX)
        found_points, status, _ = cv2.calcOpticalFlowPyrLK(
            first, other, points, points.copy(), winSize=size, maxLevel=4
        )
        return found_points, status


def _similar(points: Array) -> Array:
    """Return what a shift in x and y, a turn and a growth move of points (N, 2), (2 N, 4)."""
    x, y = np.asarray(points, float).T
    one, none = np.ones_like(x), np.zeros_like(x)
    return np.stack([[one, none, -y, x], [none, one, x, y]]).transpose(2, 0, 1).reshape(-1, 4)


def _even(picture: Grey) -> Grey:
    """Return a picture divided by its own brightness nearby: lamps flicker, phones adapt."""
    import cv2

    near = cv2.blur(picture, (NEAR_PX, NEAR_PX))
    return np.asarray(cv2.divide(picture, near, scale=128), np.uint8)
