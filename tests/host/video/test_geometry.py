"""Edges of tags, harmonics and long films, tested without rendering whole films."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from serpenoid.base.sines import basis, weighted
from serpenoid.video.fitting.start import first_cameras
from serpenoid.video.instrument import follow, measure
from serpenoid.video.seeing.edges import refine
from serpenoid.video.seeing.sightings import Sightings
from video.filming import Lens
from video.worlds import LINK_M, SIDE_M, World, crawling

SQUARE = 0.5 * SIDE_M * np.array([[-1.0, 1.0], [1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]])
NOISE_PX = 0.15


def drawn_square(quad: np.ndarray, blur_px: float, subpixels: int = 16) -> np.ndarray:
    """Return a picture of a black square with a white rim, averaged over each pixel."""
    big = np.full((120 * subpixels, 120 * subpixels), 160, np.uint8)
    middle = quad.mean(axis=0)
    for scale, grey in ((8 / 6, 235), (1.0, 25)):
        shape = (middle + scale * (quad - middle) + 0.5) * subpixels - 0.5
        cv2.fillConvexPoly(big, np.round(shape * 16).astype(np.int32), grey, shift=4)
    small = cv2.resize(big, (120, 120), interpolation=cv2.INTER_AREA)
    return cv2.GaussianBlur(small, (0, 0), blur_px)


@pytest.mark.parametrize("off_px", [-2.0, 2.0])
def test_motion_blur_does_not_change_the_size_of_a_tag(off_px: float) -> None:
    """The blur is 3 pixels, half a cell of the tag; the first corners are wrong across it."""
    square = 17 * np.array([[-1.0, -1], [1, -1], [1, 1], [-1, 1]]) + [60.3, 58.8]
    picture = cv2.blur(drawn_square(square, 0.5), (3, 1))
    start = square + off_px * np.sign(square - square.mean(axis=0)) * [1, 0]
    found, _ = refine(picture, start[None])
    assert found[0, 1, 0] - found[0, 0, 0] == pytest.approx(34, abs=0.15)


def test_harmonics_stay_small_if_part_of_a_cycle_is_not_visible() -> None:
    rng = np.random.default_rng(0)
    t = np.linspace(0.0, 10.0, 600)
    phi = np.sin(2 * np.pi * t)[:, None] + 0.01 * rng.normal(size=(600, 1))
    visible = ((t % 1.0) < 0.25).astype(float)[:, None]
    found = weighted(basis(t, 2 * np.pi), phi, visible)
    assert np.hypot(found[1, 0], found[2, 0]) == pytest.approx(1.0, abs=0.1)
    assert np.abs(found[3:]).max() < 0.3  # 3.2 without a penalty


def sightings_of(world: World, t_s: np.ndarray, lens: Lens) -> Sightings:
    """Return the pixels of the tags' corners in a pinhole camera, with noise."""
    poses = [world.pose(t) for t in t_s]
    centre, theta = np.array([p[0] for p in poses]), np.array([p[1] for p in poses])
    cos, sin = np.cos(theta)[..., None], np.sin(theta)[..., None]
    x = centre[..., :1] + cos * SQUARE[:, 0] - sin * SQUARE[:, 1]
    y = centre[..., 1:] + sin * SQUARE[:, 0] + cos * SQUARE[:, 1]
    pixels = lens.pixels(np.stack([x, y, np.full_like(x, 0.045)], axis=-1))
    noise = np.random.default_rng(1).normal(size=pixels.shape)
    return Sightings.from_corners(t_s, pixels + NOISE_PX * noise, (lens.width, lens.height))


def test_a_long_film_is_measured() -> None:
    seconds = 21
    world = crawling(links=3, omega_rad_s=4.0, speed_m_s=0.2 / seconds, start_m=-0.1)
    sightings = sightings_of(world, np.arange(0, seconds, 1 / 30), Lens())
    cameras = first_cameras(sightings, LINK_M, SIDE_M)
    found = measure(*follow(sightings, SIDE_M, cameras))
    motion = found.motion
    assert motion.omega_rad_s == pytest.approx(world.omega_rad_s, abs=5 * found.sigmas[0])
    assert found.sigmas[0] < 1e-3 * world.omega_rad_s / seconds
    assert motion.amplitude_rad == pytest.approx(world.amplitude_rad, abs=np.radians(0.1))
    assert motion.speed_m_s == pytest.approx(world.speed_m_s, rel=0.003)
    assert found.sigmas[1 : world.links].max() < np.radians(0.1)
