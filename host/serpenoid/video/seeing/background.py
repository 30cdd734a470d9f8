"""Follow points of the floor through a film, to tell whether the camera stood still."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from ..arrays import Grey

PATCH_PX = 21  # Side of the square round each followed point.


class Background:
    """Follow the floor's points from the first frame to a later one, and back again.

    A point counts if it returns to its place and moves with most others; noise does neither.

    shifts: (time, s; x and y shift of the floor at the robot, px; its standard deviation, px) for
    each compared frame in which enough points count. looks: number of compared frames. picture:
    the first frame with a tag.
    """

    def __init__(self) -> None:
        self.shifts: list[tuple[float, float, float, float]] = []
        self.looks = 0
        self.picture: Any = None
        self._next_s = -np.inf

    @property
    def plain(self) -> bool:
        """Return whether the floor has too few points that can be followed."""
        return len(self.shifts) <= self.looks / 2

    def look(self, time_s: float, picture: Grey, window: tuple[int, int, int, int] | None) -> None:
        """Compare a frame with the first one that has tags, half a second after the one before.

        window: the robot's left, top, right and bottom edge in the frame, px; None without tags.
        """
        import cv2

        if time_s < self._next_s or (self.picture is None and window is None):
            return
        self._next_s = time_s + 0.5
        if window and self.picture is None:
            self.picture, self.window = np.array(picture), window
            free = np.full(picture.shape, 255, np.uint8)
            left_px, top, right, bottom = window
            free[top:bottom, left_px:right] = 0
            self._first = _even(self.picture)
            self._points: Any = cv2.goodFeaturesToTrack(  # (points, 1, 2) float32
                self.picture, 150, 0.02, PATCH_PX, mask=free, blockSize=7
            )
            return
        self.looks += 1
        if self._points is None:
            return
        max_error_px = 1.0  # Deviation from the common motion; points beyond it are on a foot.
        min_points = 12  # Fewest points whose common motion is trusted.
        later = _even(np.ascontiguousarray(picture))
        follow: Any = partial(cv2.calcOpticalFlowPyrLK, winSize=(PATCH_PX, PATCH_PX), maxLevel=4)
        forward_points, status, _ = follow(self._first, later, self._points, self._points.copy())
        returned_points, returned_status, _ = follow(
            later, self._first, forward_points, forward_points.copy()
        )
        distance = np.linalg.norm(returned_points - self._points, axis=2).ravel()
        is_good = (status & returned_status).ravel() == 1
        is_good &= distance < max_error_px
        if is_good.sum() < max(min_points, len(is_good) / 3):
            return
        start, end = self._points[is_good, 0], forward_points[is_good, 0]
        _, inliers = cv2.estimateAffinePartial2D(start, end, ransacReprojThreshold=max_error_px)
        is_common = inliers.ravel() == 1
        if is_common.sum() >= max(min_points, is_good.sum() / 2):
            # Fit translation, rotation and growth of the picture by least squares, with points as
            # complex numbers: shift = mean + growth (point - middle). The shift reported is the
            # largest of the window's corners, so that a rotation about its middle counts too.
            point, shift = (pixels[is_common] @ [1, 1j] for pixels in (start, end - start))
            middle, mean = point.mean(), shift.mean()
            arm = point - middle
            inertia = np.sum(np.abs(arm) ** 2)
            growth = arm.conj() @ shift / inertia
            left_px, top, right, bottom = self.window
            corners = np.add.outer([left_px, right], [1j * top, 1j * bottom])
            corner_arm = corners.ravel() - middle
            corner_shift = mean + growth * corner_arm
            largest = int(np.abs(corner_shift).argmax())
            errors = shift - mean - growth * arm
            variance = np.sum(np.abs(errors) ** 2) / (2 * len(arm) - 4)
            sigma = np.sqrt(variance * (1 / len(arm) + abs(corner_arm[largest]) ** 2 / inertia))
            shift_px = corner_shift[largest]
            self.shifts.append((time_s, shift_px.real, shift_px.imag, float(sigma)))


def _even(picture: Grey) -> Grey:
    """Return a picture over its local mean brightness: lamps flicker, and phones adapt."""
    import cv2

    blurred = cv2.blur(picture, (2 * PATCH_PX + 1,) * 2)
    return np.asarray(cv2.divide(picture, blurred, scale=128), np.uint8)
