"""Where a pinhole sees the corners of a robot's tags: sightings without pictures."""

from __future__ import annotations

import numpy as np
from serpenoid.video.seeing.sightings import Sightings
from video.filming import Lens
from video.worlds import SIDE_M, World

SQUARE = 0.5 * SIDE_M * np.array([[-1.0, 1.0], [1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]])
NOISE_PX = 0.15


def sighted(
    world: World, t_s: np.ndarray, lens: Lens, told_s: np.ndarray | None = None
) -> Sightings:
    """Return where a pinhole sees the tags' corners, with noise; told_s: the file's times."""
    poses = [world.pose(t) for t in t_s]
    centre, theta = np.array([p[0] for p in poses]), np.array([p[1] for p in poses])
    cos, sin = np.cos(theta)[..., None], np.sin(theta)[..., None]
    x = centre[..., :1] + cos * SQUARE[:, 0] - sin * SQUARE[:, 1]
    y = centre[..., 1:] + sin * SQUARE[:, 0] + cos * SQUARE[:, 1]
    pixels = lens.pixels(np.stack([x, y, np.full_like(x, 0.045)], axis=-1))
    noise = np.random.default_rng(1).normal(size=pixels.shape)
    told_s = t_s if told_s is None else told_s
    return Sightings.of(told_s, pixels + NOISE_PX * noise, (lens.width, lens.height))
