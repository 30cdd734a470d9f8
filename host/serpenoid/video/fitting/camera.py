"""Camera and tag mountings: from a chain of links to the pixels of every tag's corners.

World: the plane of the tags; z points up to the camera, and the origin is where the optical axis
meets the plane. A camera point is P = R X + (0, 0, D) with the axes right, down, forward; the
image is c + f (P_x, P_y) (1 + k1 r^2 + k2 r^4) / P_z. Rows are read one after the other, the last
one readout_s after the first: who fits adds that to the pixels (`Sightings.skew`).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.spatial.transform import Rotation

from ..arrays import Array
from .chain import link_centres

# Unknowns that all frames share: these, then MOUNTING of every link.
LENS = (
    "log_focal",
    "k1",
    "k2",
    "centre_x",
    "centre_y",
    "tilt_x",
    "tilt_y",
    "log_distance",
    "log_side",
    "readout_s",
)
MOUNTING = ("dx_m", "dy_m", "turn_rad", "height_m", "slope_x", "slope_y")

STEP = 1e-6  # Step of an unknown, for the pixels' derivatives by differences.


@dataclass(frozen=True)
class Camera:
    """What all frames of a film share, and how a chain of links looks through it.

    links; link_m: link length; image_px: width and height. shared: (10 + 6 links,) the unknowns
    LENS and, link by link, MOUNTING; focal length and principal point in units of the image's
    longer side, the tag's side and its mounting in m, in the link's frame.
    """

    links: int
    link_m: float
    image_px: tuple[int, int]
    shared: Array

    @property
    def focal_px(self) -> float:
        """Return the focal length, px."""
        return float(max(self.image_px) * np.exp(self.shared[0]))

    @property
    def readout_s(self) -> float:
        """Return the time from the first row to the last one, s."""
        return self.shared[LENS.index("readout_s")]

    def with_turns(self, turns: Array) -> Camera:
        """Return the camera with every tag turned on its link, (links,) rad."""
        shared = self.shared.copy()
        shared[len(LENS) + MOUNTING.index("turn_rad") :: len(MOUNTING)] = turns
        return replace(self, shared=shared)

    @cached_property
    def pose(self) -> tuple[Array, float]:
        """Return R, world to camera, and the distance D to the plane along the axis, m."""
        tilted = Rotation.from_rotvec([*self.shared[5:7], 0.0]).as_matrix()
        return tilted * [1.0, -1.0, -1.0], float(np.exp(self.shared[7]))

    @property
    def side_m(self) -> float:
        """Return the side of a tag, m."""
        return float(np.exp(self.shared[8]))

    def corners(self, states: Array) -> Array:
        """Return the corners in the world, (frames, links, 4, 3)."""
        mounting = self.shared[len(LENS) :].reshape(self.links, len(MOUNTING), 1)
        dx, dy, turn, height, slope_x, slope_y = mounting.transpose(1, 0, 2)
        tag_x, tag_y = self.side_m * 0.5 * np.array([[-1, 1, 1, -1], [1, 1, -1, -1]])
        cos, sin = np.cos(turn), np.sin(turn)
        x, y = dx + cos * tag_x - sin * tag_y, dy + sin * tag_x + cos * tag_y  # of the link
        theta = states[:, 2:, None]
        cos, sin = np.cos(theta), np.sin(theta)
        rotated = np.stack([cos * x - sin * y, sin * x + cos * y], axis=-1)
        flat = link_centres(states, self.link_m)[:, :, None] + rotated
        heights = np.broadcast_to(height + slope_x * tag_x + slope_y * tag_y, flat.shape[:-1])
        return np.concatenate([flat, heights[..., None]], axis=-1)

    def image(self, world: Array) -> Array:
        """Return the pixels of world points (..., 3), (..., 2); behind the camera: NaN."""
        turn, distance = self.pose
        point = world @ turn.T + [0.0, 0.0, distance]
        depth = np.where(point[..., 2:] > 1e-6 * distance, point[..., 2:], np.nan)
        flat = point[..., :2] / depth
        return self._middle_px + self.focal_px * flat * self._stretch(flat)

    def _stretch(self, flat: Array) -> Array:
        """Return the lens' factor 1 + k1 r^2 + k2 r^4 for (..., 2) before it, (..., 1)."""
        k1, k2 = self.shared[1:3]
        r2 = np.sum(flat**2, axis=-1, keepdims=True)
        return 1 + r2 * (k1 + k2 * r2)

    def plane_px(self, places: Array) -> Array:
        """Return the pixels of places (..., 2), m, in the plane of the tags."""
        return self.image(np.insert(places, 2, 0.0, axis=-1))

    @property
    def _middle_px(self) -> Array:
        half = 0.5 * (np.array(self.image_px) - 1.0)
        return half + max(self.image_px) * self.shared[3:5]

    def on_plane(self, pixels: Array) -> Array:
        """Return where pixels (..., 2) meet the plane of the tags, (..., 2), m."""
        d = (pixels - self._middle_px) / self.focal_px
        q = d
        for _ in range(8 * self.shared[1:3].any()):  # the distortion undone: a fixed point
            q = d / self._stretch(q)
        turn, distance = self.pose
        ray = np.concatenate([q, np.ones((*q.shape[:-1], 1))], axis=-1) @ turn
        start = -np.array([0.0, 0.0, distance]) @ turn
        return (start - ray * (start[2] / ray[..., 2:]))[..., :2]

    def by_states(self, states: Array) -> Array:
        """Return the pixels' derivatives by the states, (frames, links, 4, 2, links + 2)."""
        steps = np.eye(states.shape[1] + 1, states.shape[1], -1)[:, None]  # the first one is none
        stepped_states = np.concatenate(states + STEP * steps)  # as so many more frames
        base, *stepped = np.split(self.image(self.corners(stepped_states)), len(steps))
        return np.stack(stepped, axis=-1) / STEP - base[..., None] / STEP

    def by_shared(self, states: Array) -> Array:
        """Return the pixels' derivatives by what is shared, (frames, links, 4, 2, 10 + 6 links)."""
        base = self.image(self.corners(states))
        slopes = []
        for step in STEP * np.eye(len(self.shared)):
            camera = replace(self, shared=self.shared + step)
            slopes.append((camera.image(camera.corners(states)) - base) / STEP)
        return np.stack(slopes, axis=-1)
