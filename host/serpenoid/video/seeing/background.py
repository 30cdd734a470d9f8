"""Whether the camera stood still: points of the floor, followed from the first frame on."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..arrays import Grey

EVERY_S = 0.5  # Time between looks.
LEAST_POINTS = 12
PATCH_PX = 21  # Side of the patch round a point that is followed.
REACH_PX = 1.0  # Distance from the floor's common motion beyond which a point is somebody's foot.


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
        left_px, top, right, bottom = window
        free[top:bottom, left_px:right] = 0
        pixels = np.ascontiguousarray(picture)
        self._first = _even(pixels)
        self._points: Any = cv2.goodFeaturesToTrack(  # (points, 1, 2) float32
            pixels, 150, 0.02, PATCH_PX, mask=free, blockSize=7
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
            # The picture moves, turns and grows: by how much did the window's corner move that
            # moved most? So a picture that turns or grows about its middle has moved, too.
            # In complex numbers: shift = mean + growth (place - middle), by least squares.
            place, shift = (pixels[is_common] @ [1, 1j] for pixels in (start, end - start))
            middle, mean = place.mean(), shift.mean()
            arm = place - middle
            inertia = np.sum(np.abs(arm) ** 2)
            growth = arm.conj() @ shift / inertia
            left_px, top, right, bottom = self.window
            lever = np.add.outer([left_px, right], [1j * top, 1j * bottom]).ravel() - middle
            moved = mean + growth * lever
            worst = int(np.abs(moved).argmax())
            residual = np.sum(np.abs(shift - mean - growth * arm) ** 2) / (2 * len(arm) - 4)
            sigma = np.sqrt(residual * (1 / len(arm) + abs(lever[worst]) ** 2 / inertia))
            self.shifts.append((time_s, moved[worst].real, moved[worst].imag, float(sigma)))

    @staticmethod
    def _follow(first: Any, later: Any, points: Any) -> tuple[Any, Any]:
        import cv2

        size = (PATCH_PX, PATCH_PX)
        found_points, status, _ = cv2.calcOpticalFlowPyrLK(
            first, later, points, points.copy(), winSize=size, maxLevel=4
        )
        return found_points, status


def _even(picture: Grey) -> Grey:
    """Return a picture divided by its own brightness nearby: lamps flicker, phones adapt."""
    import cv2

    blurred = cv2.blur(picture, (2 * PATCH_PX + 1,) * 2)
    return np.asarray(cv2.divide(picture, blurred, scale=128), np.uint8)
