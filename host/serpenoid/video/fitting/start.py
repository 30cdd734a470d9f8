"""Where the fit of camera and chain starts: the plane in which the tags look most like squares."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np

from ..arrays import Array
from ..seeing.sightings import Sightings
from .camera import LENS, MOUNTING, Camera
from .chain import filled_headings, link_centres


def first_cameras(sightings: Sightings, link_m: float, side_m: float) -> list[Camera]:
    """Return cameras to start from, best first.

    The best plane of every focal length, and the best of all that leans the other way: small
    squares look nearly the same from both sides.
    """
    corners = sightings.corners_px[sightings.visible]
    corners = corners[:: max(1, len(corners) // 200)].astype(float)
    around = np.arange(16) * np.pi / 8
    tilts = np.radians(np.arange(0, 73, 8))[:, None, None] * np.stack(
        [np.cos(around), np.sin(around)], axis=-1
    )
    focals, candidates = (0.6, 0.75, 0.95, 1.3, 2.0), []  # over the picture's longer side
    for focal, tilt in product(focals, tilts.reshape(-1, 2)[15:]):
        shared = np.zeros(len(LENS) + len(MOUNTING) * sightings.links)
        shared[0], shared[8] = np.log(focal), np.log(side_m)
        shared[5:7] = tilt
        camera = Camera(sightings.links, link_m, sightings.image_px, shared)
        flat = camera.on_plane(corners)
        sides = np.linalg.norm(np.roll(flat, -1, axis=-2) - flat, axis=-1)
        diagonals = np.linalg.norm(flat[..., :2, :] - flat[..., 2:, :], axis=-1) / np.sqrt(2)
        logs = np.log(np.concatenate([sides, diagonals], axis=-1))
        # how far they are from squares of one size
        spread = float(np.abs(logs - np.median(logs)).mean())
        log_distance = np.log(side_m / np.median(sides)) * np.eye(len(shared))[7]
        camera = replace(camera, shared=shared + log_distance)
        candidates.append((spread if np.isfinite(spread) else np.inf, focal, camera))
    candidates.sort(key=lambda trial: trial[0])
    best: dict[float, Camera] = {}
    for _, focal, camera in candidates:
        best.setdefault(focal, camera)
    best_tilt = candidates[0][2].shared[5:7]
    opposite = [camera for *_, camera in candidates if camera.shared[5:7] @ best_tilt < 0]
    return [*best.values(), *opposite[:1]]


def tag_poses(camera: Camera, sightings: Sightings) -> tuple[Array, Array]:
    """Return centre (frames, links, 2) and heading (frames, links) of every tag in the plane."""
    flat = camera.on_plane(sightings.corners_px.astype(float))
    right = flat[..., 1, :] - flat[..., 0, :] + flat[..., 2, :] - flat[..., 3, :]
    return flat.mean(axis=-2), np.arctan2(right[..., 1], right[..., 0])


def quarter_turns(centres: Array, headings: Array) -> Array:
    """Return how every tag is turned on its link, (links,), in whole quarter turns, rad.

    A link points from the tag before it to the tag after it, in the mean over the film.
    """
    directions = np.gradient(centres, axis=1)
    turns = np.exp(1j * (np.arctan2(directions[..., 1], directions[..., 0]) - headings))
    mean = np.angle(np.nan_to_num(turns).sum(axis=0))
    return -np.round(mean / (np.pi / 2)) * np.pi / 2


def first_states(camera: Camera, sightings: Sightings, turns: Array) -> Array:
    """Return states (frames, links + 2) from the tags that are there; others by interpolation.

    In time; a link that was never seen points between those beside it.
    """
    centres, headings = tag_poses(camera, sightings)
    states = np.full((len(headings), headings.shape[1] + 2), np.nan)
    for i, theta in enumerate((headings - turns).T, 2):
        mask = np.isfinite(theta)
        if mask.any():
            smooth = np.unwrap(theta[mask])
            states[:, i] = np.interp(sightings.t_s, sightings.t_s[mask], smooth)
    states = filled_headings(states, np.isfinite(states[:, 2:]), np.zeros(headings.shape[1] - 1))
    states[:, :2] = 0.0
    states[:, :2] = np.nanmean(centres - link_centres(states, camera.link_m), axis=1)
    return states
