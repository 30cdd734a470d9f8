"""One moment of a snake as pixels, from above; the camera goes along, and the ground's grid stays.

It needs NumPy alone, so that an environment for learning draws without a screen.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..model.link_state import LinkState
from ..model.robot import Robot
from ..model.vectors import Array

HIGH, WIDE = 300, 600  # pixels
BODIES_WIDE = 2.0  # body lengths in a picture's width
LINK_HALF, LINK_RADIUS = 0.35, 0.12  # of a link as drawn, in link lengths
GROUND, GRID, LINK, HEAD = (
    np.array(rgb, dtype=float)
    for rgb in ((247, 246, 242), (216, 213, 204), (0, 114, 178), (213, 94, 0))
)


def picture(robot: Robot, state: LinkState) -> NDArray[np.uint8]:
    """Return (HIGH, WIDE, 3) pixels: red, green and blue, the upper row first."""
    pixel_m = BODIES_WIDE * robot.body_length_m / WIDE
    x_m = state.x_m.mean() + pixel_m * (np.arange(WIDE) - (WIDE - 1) / 2)
    y_m = state.y_m.mean() - pixel_m * (np.arange(HIGH) - (HIGH - 1) / 2)
    length = robot.link_length_m
    picture = np.tile(GROUND, (HIGH, WIDE, 1))
    picture[:, _on_grid(x_m, length, pixel_m)] = GRID
    picture[_on_grid(y_m, length, pixel_m)] = GRID
    links = zip(state.x_m, state.y_m, state.theta_rad, strict=True)
    for number, (x, y, theta) in enumerate(links, 1):
        colour = HEAD if number == robot.links else LINK
        away = _distance(x_m - x, y_m[:, None] - y, theta, LINK_HALF * length)
        covered = np.clip((LINK_RADIUS * length - away) / pixel_m + 0.5, 0.0, 1.0)[..., None]
        picture += covered * (colour - picture)
    return np.rint(picture).astype(np.uint8)


def _on_grid(values: Array, period: float, pixel_m: float) -> NDArray[np.bool_]:
    """Tell which pixels a line of the grid crosses: one line a period."""
    return np.floor(values / period) != np.floor((values - pixel_m) / period)


def _distance(x: Array, y: Array, theta: float, half: float) -> Array:
    """Return the distance of points from a segment about the origin."""
    along = x * np.cos(theta) + y * np.sin(theta)
    across = y * np.cos(theta) - x * np.sin(theta)
    return np.hypot(along - np.clip(along, -half, half), across)
