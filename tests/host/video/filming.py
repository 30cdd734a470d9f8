"""A renderer of films by rays from each pixel to floor, links and tags.

It shares no formula with the measurement: rays are traced from pixels into the world, lens
distortion is inverted by iteration, every tag has its own height and tilt, rows are exposed one
after the other.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any

import av
import cv2
import numpy as np

Pose = Callable[[float], tuple[np.ndarray, np.ndarray]]  # time -> centres (n, 2), headings (n,)


@dataclass(frozen=True)
class Lens:
    """A camera on a tripod: position, target, image size, distortion, exposure and noise."""

    eye_m: tuple[float, float, float] = (0.0, -0.35, 0.75)
    target_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
    width: int = 640
    height: int = 360
    focal_px: float = 800.0
    k1: float = 0.0
    k2: float = 0.0
    middle_px: tuple[float, float] = (0.0, 0.0)  # of the optical axis from the image's middle
    exposure_s: float = 0.004
    rolling_s: float = 0.0  # readout of all rows
    noise: float = 2.0

    def axes(self) -> np.ndarray:
        """Return the camera's right, down and forward axes in the world, (3, 3)."""
        forward = np.subtract(self.target_m, self.eye_m)
        forward /= np.linalg.norm(forward)
        right = np.cross(forward, [0.0, 1.0, 0.0] if abs(forward[2]) > 0.999 else [0.0, 0.0, 1.0])
        right /= np.linalg.norm(right)
        return np.array([right, np.cross(forward, right), forward])

    def pixels(self, points: np.ndarray) -> np.ndarray:
        """Return the pixels of points (..., 3) in the world, (..., 2)."""
        x, y, depth = np.moveaxis((points - np.array(self.eye_m)) @ self.axes().T, -1, 0)
        flat = np.stack([x, y], axis=-1) / depth[..., None]
        s = np.sum(flat**2, axis=-1, keepdims=True)
        middle = 0.5 * np.array([self.width - 1, self.height - 1]) + self.middle_px
        return middle + self.focal_px * flat * (1 + self.k1 * s + self.k2 * s**2)

    def rays(self) -> np.ndarray:
        """Return the direction of each pixel in the world, (height, width, 3)."""
        columns = np.arange(self.width) + 0.5 - self.width / 2 - self.middle_px[0]
        rows = np.arange(self.height) + 0.5 - self.height / 2 - self.middle_px[1]
        distorted = np.stack(np.meshgrid(columns, rows), axis=-1) / self.focal_px
        ideal = distorted.copy()
        for _ in range(30):
            s = np.sum(ideal**2, axis=-1, keepdims=True)
            ideal = distorted / (1 + self.k1 * s + self.k2 * s**2)
        return (np.insert(ideal, 2, 1.0, axis=-1) @ self.axes()).astype(np.float32)


@dataclass(frozen=True)
class Body:
    """Links with tags: their sizes, and the mounting of each tag."""

    links: int = 6
    link_m: float = 0.076
    side_m: float = 0.034
    width_m: float = 0.045
    height_m: float = 0.045
    mount_m: Any = ((0.0, 0.0, 0.0),) * 13  # (links, 3): dx, dy, lift
    turn_rad: Any = (0.0,) * 13
    slope: Any = ((0.0, 0.0),) * 13  # (links, 2)
    ids: tuple[int, ...] | None = None


@dataclass(frozen=True)
class Glare:
    """The reflection of a lamp, in which tags are too bright to be seen."""

    centre_m: tuple[float, float] = (0.0, 0.0)
    radius_m: float = 0.08
    strength: float = 220.0


@dataclass
class Film:
    """A film of a moving body; it draws frames at given times."""

    lens: Lens
    body: Body
    pose: Pose
    seed: int = 1
    glare: Glare | None = None
    up: int = 3
    steps: int = 1  # number of times averaged in an exposure

    def __post_init__(self) -> None:
        self.rng = np.random.default_rng(self.seed)
        self.eye, self.directions = np.array(self.lens.eye_m), self.lens.rays()
        self.floor = self._floor()
        self.shine = 0.0 if self.glare is None else self._shine(self.glare)
        words = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
        ids = self.body.ids or tuple(range(self.body.links))
        self.bits = [np.pad(words.generateImageMarker(i, 6), 1, constant_values=255) for i in ids]
        size = 3, self.lens.height, self.lens.width
        self.grain = self.rng.normal(0, self.lens.noise, size).astype(np.float32)

    def _floor(self) -> np.ndarray:
        """Return the still background: wood-like noise of several sizes."""
        x, y = self._plane(0.0)
        tile = np.zeros((512, 512), np.float32)
        for size, strength in ((8, 14), (32, 12), (128, 10)):
            coarse = self.rng.normal(0, strength, (size, size)).astype(np.float32)
            tile += cv2.resize(coarse, (512, 512), interpolation=cv2.INTER_CUBIC)
        planks = 10 * ((np.floor(y / 0.09) % 2) - 0.5)
        across, along = (((v * 600) % 511).astype(np.float32) for v in (x, y))
        look = cv2.remap(tile, across, along, cv2.INTER_LINEAR)
        return 135 + look + planks.astype(np.float32)

    def frame(self, t_s: float) -> np.ndarray:
        """Return one frame, (height, width) of bytes."""
        image = self.floor.copy()
        for i in range(self.body.links):
            self._link(image, i, t_s)
        image += self.shine
        image += np.roll(self.grain[self.rng.integers(3)], self.rng.integers(997))
        return np.clip(image, 0, 255).astype(np.uint8)

    def _plane(self, height_m: float) -> tuple[np.ndarray, np.ndarray]:
        """Return x and y, m, where the ray of each pixel meets the plane at a height."""
        d = self.directions
        t = (height_m - self.eye[2]) / np.minimum(d[..., 2], -1e-3)
        return self.eye[0] + t * d[..., 0], self.eye[1] + t * d[..., 1]

    def _shine(self, lamp: Glare) -> np.ndarray:
        x, y = self._plane(self.body.height_m)
        distance = np.hypot(x - lamp.centre_m[0], y - lamp.centre_m[1]) / lamp.radius_m
        return (lamp.strength * np.exp(-(distance**4))).astype(np.float32)

    def _box(self, i: int, t_s: float) -> tuple[slice, slice]:
        """Return the pixels that a link can touch while the frame is exposed, with a margin."""
        lens, body = self.lens, self.body
        span_s = lens.exposure_s + lens.rolling_s
        centres = np.array([self.pose(t_s + late)[0][i] for late in (-span_s, 0.0, span_s)])
        pixels = lens.pixels(np.column_stack([centres, np.full(3, body.height_m)]))
        distance = np.linalg.norm(np.append(centres[1], body.height_m) - self.eye)
        margin = 0.75 * max(body.link_m, body.width_m) * lens.focal_px / distance + 4
        low, high = pixels.min(axis=0) - margin, pixels.max(axis=0) + margin
        size = np.array([lens.width, lens.height])
        (left, top), (right, bottom) = np.clip([low, high], 0, size).astype(int).tolist()
        return slice(top, bottom), slice(left, right)

    def _link(self, image: np.ndarray, i: int, t_s: float) -> None:
        box = rows, columns = self._box(i, t_s)
        if rows.start >= rows.stop or columns.start >= columns.stop:
            return
        d = self.directions[rows, columns]
        size = (d.shape[1] * self.up, d.shape[0] * self.up)
        d = cv2.resize(d, size, interpolation=cv2.INTER_LINEAR)
        row = (np.arange(size[1]) + 0.5) / self.up + rows.start
        colour, cover = 0.0, 0.0
        for k in range(self.steps):
            delay_s = ((k + 0.5) / self.steps - 0.5) * self.lens.exposure_s
            light, hit = self._trace(i, d, t_s + delay_s, row)
            colour, cover = colour + light * hit, cover + hit
        small = (size[0] // self.up, size[1] // self.up)
        light = cv2.resize(np.asarray(colour, np.float32), small, interpolation=cv2.INTER_AREA)
        hit = cv2.resize(np.asarray(cover, np.float32), small, interpolation=cv2.INTER_AREA)
        image[box] = image[box] * (1 - hit / self.steps) + light / self.steps

    def _trace(
        self, i: int, d: np.ndarray, t_s: float, row: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the light on each ray, and whether it meets link i."""
        b = self.body
        first, last = (row[0] / self.lens.height - 0.5), (row[-1] / self.lens.height - 0.5)
        ends = [self.pose(t_s + f * self.lens.rolling_s) for f in (first, last)]
        share = ((row - row[0]) / (row[-1] - row[0]))[:, None].astype(np.float32)
        (c0, h0), (c1, h1) = [(c[i], h[i]) for c, h in ends]
        cx, cy = c0[0] + share * (c1[0] - c0[0]), c0[1] + share * (c1[1] - c0[1])
        angle = h0 + share * (h1 - h0)
        (dx, dy, lift), turn, slope = b.mount_m[i], b.turn_rad[i], b.slope[i]
        cos, sin = np.cos(angle).astype(np.float32), np.sin(angle).astype(np.float32)
        # The tag's plane in the link's frame: z = height + lift + slopes, about the tag's middle.
        ex, ey = np.float32(self.eye[0]) - cx, np.float32(self.eye[1]) - cy
        ox, oy = cos * ex + sin * ey - dx, -sin * ex + cos * ey - dy
        vx, vy = cos * d[..., 0] + sin * d[..., 1], -sin * d[..., 0] + cos * d[..., 1]
        ct, st = np.float32(np.cos(turn)), np.float32(np.sin(turn))
        ox, oy = ct * ox + st * oy, ct * oy - st * ox
        vx, vy = ct * vx + st * vy, ct * vy - st * vx
        oz = np.float32(self.eye[2] - b.height_m - lift)
        t = (slope[0] * ox + slope[1] * oy - oz) / (d[..., 2] - slope[0] * vx - slope[1] * vy)
        x, y = ox + t * vx, oy + t * vy
        hit = (np.abs(x) < 0.42 * b.link_m) & (np.abs(y) < b.width_m / 2)
        cell = np.float32(6 / b.side_m)
        column = np.clip((x * cell + 4).astype(np.int32), 0, 7)
        line = np.clip((4 - y * cell).astype(np.int32), 0, 7)
        bright = self.bits[i][line, column] * np.float32(0.82) + np.float32(22)
        label = (np.abs(x * cell) < 4) & (np.abs(y * cell) < 4)
        return np.where(label, bright, np.float32(70)), hit.astype(np.float32)


def write(
    path: Path,
    frames: list[np.ndarray],
    times_s: np.ndarray,
    crf: int = 20,
    gop: int = 250,
) -> Path:
    """Encode frames at their times, as a phone does; gop: frames from one key frame to the next."""
    with av.open(str(path), "w") as box:
        stream = box.add_stream("libx264", rate=30)
        stream.height, stream.width = frames[0].shape
        stream.pix_fmt = "yuv420p"
        stream.options = {"crf": str(crf), "preset": "veryfast", "g": str(gop)}
        stream.time_base = Fraction(1, 90000)
        stream.codec_context.time_base = Fraction(1, 90000)
        stream.codec_context.thread_count = 1
        for image, t in zip(frames, times_s, strict=True):
            picture = av.VideoFrame.from_ndarray(image, format="gray").reformat(format="yuv420p")
            picture.pts = round(t * 90000)
            picture.time_base = Fraction(1, 90000)
            box.mux(stream.encode(picture))
        box.mux(stream.encode())
    return path
