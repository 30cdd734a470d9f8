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
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from .chain import lever_matrix, link_centres

Array = NDArray[np.float64]

# The unknowns that all frames share: these, then MOUNTING of every link.
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
CORNERS = 0.5 * np.array([[-1.0, 1.0], [1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]])
_LOOKING_DOWN = np.diag([1.0, -1.0, -1.0])


def rotation(tilt_x: float, tilt_y: float) -> Array:
    """Return R, world to camera: a camera that looks straight down, then tilted, rad."""
    return Rotation.from_rotvec([tilt_x, tilt_y, 0.0]).as_matrix() @ _LOOKING_DOWN


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
    def scale_px(self) -> float:
        """Return the image's longer side, px."""
        return float(max(self.image_px))

    def with_turns(self, turns: Array) -> Camera:
        """Return the camera with every tag turned on its link, (links,) rad."""
        shared = self.shared.copy()
        shared[len(LENS) + MOUNTING.index("turn_rad") :: len(MOUNTING)] = turns
        return replace(self, shared=shared)

    @cached_property
    def mounting(self) -> Array:
        """Return dx, dy, turn, height and slopes of every tag, (links, 6)."""
        return self.shared[len(LENS) :].reshape(self.links, len(MOUNTING))

    @cached_property
    def pose(self) -> tuple[Array, float]:
        """Return R, world to camera, and the distance D to the plane along the axis, m."""
        return rotation(*self.shared[5:7]), float(np.exp(self.shared[7]))

    @property
    def side_m(self) -> float:
        """Return the side of a tag, m."""
        return float(np.exp(self.shared[8]))

    def on_link(self) -> tuple[Array, Array]:
        """Return the corners in their link's frame, (links, 4, 2), and their heights (links, 4)."""
        dx, dy, turn, height, slope_x, slope_y = self.mounting.T[:, :, None]
        x, y = self.side_m * CORNERS.T
        cos, sin = np.cos(turn), np.sin(turn)
        flat = np.stack([dx + cos * x - sin * y, dy + sin * x + cos * y], axis=-1)
        return flat, height + slope_x * x + slope_y * y

    def corners(self, states: Array) -> Array:
        """Return the corners in the world, (frames, links, 4, 3)."""
        flat, up = self.on_link()
        theta = states[:, 2:, None]
        cos, sin = np.cos(theta), np.sin(theta)
        x, y = flat[None, ..., 0], flat[None, ..., 1]
        turned = np.stack([cos * x - sin * y, sin * x + cos * y], axis=-1)
        flat_world = link_centres(states, self.link_m)[:, :, None] + turned
        heights = np.broadcast_to(up, flat_world.shape[:-1])
        return np.concatenate([flat_world, heights[..., None]], axis=-1)

    def image(self, world: Array) -> Array:
        """Return the pixels of world points (..., 3), (..., 2); behind the camera: NaN."""
        turn, distance = self.pose
        p = world @ turn.T + np.array([0.0, 0.0, distance])
        ahead = np.where(p[..., 2:] > 1e-6 * distance, p[..., 2:], np.nan)
        q = p[..., :2] / ahead
        r2 = np.sum(q * q, axis=-1, keepdims=True)
        k1, k2 = self.shared[1:3]
        focal = self.scale_px * np.exp(self.shared[0])
        return self._middle_px + focal * q * (1 + r2 * (k1 + k2 * r2))

    @property
    def _middle_px(self) -> Array:
        half = 0.5 * (np.array(self.image_px) - 1.0)
        return half + self.scale_px * self.shared[3:5]

    def on_plane(self, pixels: Array) -> Array:
        """Return where pixels (..., 2) meet the plane of the tags, (..., 2), m."""
        k1, k2 = self.shared[1:3]
        d = (pixels - self._middle_px) / (self.scale_px * np.exp(self.shared[0]))
        q = d
        for _ in range(8):  # the distortion undone: a fixed point
            r2 = np.sum(q * q, axis=-1, keepdims=True)
            q = d / (1 + r2 * (k1 + k2 * r2))
        turn, distance = self.pose
        ray = np.concatenate([q, np.ones((*q.shape[:-1], 1))], axis=-1) @ turn
        start = -np.array([0.0, 0.0, distance]) @ turn
        return (start - ray * (start[2] / ray[..., 2:]))[..., :2]

    def jacobians(self, states: Array) -> tuple[Array, Array, Array]:
        """Return pixels and their derivatives by the states and by what is shared.

        pixels (frames, links, 4, 2); by states (frames, links, 4, 2, links + 2); by shared
        (frames, links, 4, 2, 10 + 6 links).
        """
        world = self.corners(states)
        turn, distance = self.pose
        p = world @ turn.T + np.array([0.0, 0.0, distance])
        q = p[..., :2] / p[..., 2:]
        by_point = self._by_q(q) @ _by_p(p, q)  # pixels by camera point
        by_world = by_point @ turn
        by_state = by_world[..., :2] @ self._corners_by_state(states, world)
        by_shared = np.concatenate(
            [self._by_lens(world, q, p, by_point), self._by_mounting(states, by_world)], axis=-1
        )
        return self.image(world), by_state, by_shared

    def _by_q(self, q: Array) -> Array:
        """Return the pixels' derivative by the undistorted image point, (..., 2, 2)."""
        k1, k2 = self.shared[1:3]
        r2 = np.sum(q * q, axis=-1)[..., None, None]
        outer = q[..., :, None] * q[..., None, :]
        bent = (1 + r2 * (k1 + k2 * r2)) * np.eye(2) + 2 * (k1 + 2 * k2 * r2) * outer
        return self.scale_px * np.exp(self.shared[0]) * bent

    def _corners_by_state(self, states: Array, world: Array) -> Array:
        """Return the corners' x, y by the state, (frames, links, 4, 2, links + 2)."""
        frames, n = len(states), self.links
        theta = states[:, 2:]
        across = np.stack([-np.sin(theta), np.cos(theta)], axis=-1)
        by = np.zeros((frames, n, 4, 2, n + 2))
        by[..., 0, 0] = by[..., 1, 1] = 1.0
        levers = self.link_m * lever_matrix(n)
        by[..., 2:] = np.einsum("ij,fjk->fikj", levers, across)[:, :, None]
        arm = world[..., :2] - link_centres(states, self.link_m)[:, :, None]
        own = np.arange(n)
        by[:, own, :, 0, 2 + own] -= np.moveaxis(arm[..., 1], 1, 0)
        by[:, own, :, 1, 2 + own] += np.moveaxis(arm[..., 0], 1, 0)
        return by

    def _by_lens(self, world: Array, q: Array, p: Array, by_point: Array) -> Array:
        r2 = np.sum(q * q, axis=-1, keepdims=True)
        focal = self.scale_px * np.exp(self.shared[0])
        k1, k2 = self.shared[1:3]
        shift = np.broadcast_to(self.scale_px * np.eye(2), (*q.shape, 2))
        step = 1e-6
        tilts = []
        for axis in np.eye(2):
            ends = [rotation(*(self.shared[5:7] + sign * step * axis)) for sign in (1, -1)]
            tilts.append(by_point @ (world @ (ends[0] - ends[1]).T / (2 * step))[..., None])
        columns = [focal * q * (1 + r2 * (k1 + k2 * r2)), focal * q * r2, focal * q * r2 * r2]
        farther = by_point[..., 2] * self.pose[1]
        lens = [c[..., None] for c in columns] + [shift, *tilts, farther[..., None]]
        return np.concatenate(lens, axis=-1)

    def _by_mounting(self, states: Array, by_world: Array) -> Array:
        """Return the pixels by the tags' common side and by every mounting."""
        frames, n = len(states), self.links
        _dx, _dy, turn, _h, slope_x, slope_y = self.mounting.T[:, :, None]
        x, y = self.side_m * CORNERS.T
        cos, sin, zero, one = np.cos(turn), np.sin(turn), np.zeros((n, 4)), np.ones((n, 4))
        rx, ry = cos * x - sin * y, sin * x + cos * y
        local = np.stack(
            [  # columns: side, then dx, dy, turn, height, slopes
                np.stack([rx, ry, slope_x * x + slope_y * y], axis=-1),
                np.stack([one, zero, zero], axis=-1),
                np.stack([zero, one, zero], axis=-1),
                np.stack([-ry, rx, zero], axis=-1),
                np.stack([zero, zero, one], axis=-1),
                np.stack([zero, zero, zero + x], axis=-1),
                np.stack([zero, zero, zero + y], axis=-1),
            ],
            axis=-1,
        )
        theta = states[:, 2:]
        turned = np.zeros((frames, n, 3, 3))
        turned[..., 0, 0] = turned[..., 1, 1] = np.cos(theta)
        turned[..., 1, 0] = np.sin(theta)
        turned[..., 0, 1] = -turned[..., 1, 0]
        turned[..., 2, 2] = 1.0
        by = by_world @ (turned[:, :, None] @ local[None])  # (frames, links, 4, 2, 7)
        out = np.zeros((frames, n, 4, 2, 2 + 6 * n))  # readout_s: not the camera's to know
        out[..., 0] = by[..., 0]
        for i in range(n):
            out[:, i, :, :, 2 + 6 * i : 8 + 6 * i] = by[:, i, :, :, 1:]
        return out


def _by_p(p: Array, q: Array) -> Array:
    """Return q = (P_x, P_y) / P_z by P, (..., 2, 3)."""
    by = np.zeros((*p.shape[:-1], 2, 3))
    by[..., 0, 0] = by[..., 1, 1] = 1.0
    by[..., 2] = -q
    return by / p[..., 2, None, None]
