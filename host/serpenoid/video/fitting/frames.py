"""The chain in every frame: least squares to whatever tags the frame shows, camera given."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..seeing.sightings import CHUNK, Sightings
from .bundle import OUTLIER, READOUT
from .camera import Camera

Array = NDArray[np.float64]
STEPS = 6


@dataclass(frozen=True)
class Track:
    """The chain over time.

    t_s (frames,). states (frames, links + 2): mean of the link centres x, y, then headings.
    place_variance (frames,): of x and y together, m²; joint_variance (frames, joints), rad².
    rest_px (frames, links): of a tag's corners, root mean square, NaN where no tag was found.
    by_shared (frames, links + 2, shared): how states follow the camera's unknowns; None unless
    asked for.
    """

    t_s: Array
    states: Array
    place_variance: Array
    joint_variance: Array
    rest_px: Array
    by_shared: Array | None = None


def fit_states(
    camera: Camera,
    sightings: Sightings,
    expected: Array,
    expected_sigma_rad: Array,
    noise_px: float,
    sensitive: bool = False,
) -> Track:
    """Fit every frame's state.

    expected: (frames, links + 2) where the headings are expected; expected_sigma_rad: (frames,)
    how well that is known; it decides only about links that no tag holds.
    """
    parts = []
    for first in range(0, len(expected), CHUNK):
        cut = slice(first, first + CHUNK)
        parts.append(
            _fit_chunk(
                camera,
                sightings.picked(cut),
                expected[cut],
                expected_sigma_rad[cut],
                noise_px,
                sensitive,
            )
        )
    columns = [np.concatenate(c) for c in zip(*parts, strict=True)]
    return Track(sightings.t_s, *columns)


def _fit_chunk(
    camera: Camera, s: Sightings, expected: Array, sigma: Array, noise: float, sensitive: bool
) -> tuple[Array, ...]:
    seen = s.seen
    n = seen.shape[1]
    states = expected.copy()
    known = np.zeros((len(states), n + 2))
    known[:, 2:] = 1 / sigma[:, None] ** 2
    known[:, :2] = 1e-6
    for _ in range(STEPS):
        own, a, b, residual = _equations(camera, states, s, seen, noise, known)
        pull = np.einsum("fki,fk->fi", a, residual) + known * (expected - states)
        states = states + np.linalg.solve(own, pull[..., None])[..., 0]
    own, a, b, _ = _equations(camera, states, s, seen, noise, known)
    image = camera.image(camera.corners(states)) + camera.shared[READOUT] * s.skew
    misses = np.where(seen[..., None, None], s.corners_px - image, np.nan)
    found = (states, *_variances(np.linalg.inv(own)), np.sqrt(np.mean(misses**2, axis=(2, 3))))
    if sensitive:
        found += (-np.linalg.solve(own, a.transpose(0, 2, 1) @ b),)
    return found


def _variances(covariance: NDArray[np.floating[Any]]) -> tuple[Array, Array]:
    """Return a frame's variance of its place, m², and those of its joints, rad²."""
    own = np.diagonal(covariance, axis1=1, axis2=2)
    beside = np.diagonal(covariance[:, 2:, 2:], offset=1, axis1=1, axis2=2)
    return own[:, 0] + own[:, 1], own[:, 2:-1] + own[:, 3:] - 2 * beside


def _equations(
    camera: Camera, states: Array, s: Sightings, seen: NDArray[np.bool_], noise: float, known: Array
) -> tuple[Array, Array, Array, Array]:
    """Return the normal matrix, both Jacobians and the residuals, weighted."""
    image, by_state, by_shared = camera.jacobians(states)
    by_shared[..., READOUT] = s.skew
    image = image + camera.shared[READOUT] * s.skew
    misses = np.where(seen[..., None, None], s.corners_px - image, 0.0)
    rms = np.sqrt(np.mean(misses**2, axis=(2, 3))) / noise
    root = np.sqrt(seen * np.minimum(1.0, OUTLIER / np.maximum(rms, 1e-9))) / noise
    flat = (len(states), 8 * seen.shape[1])
    a = (by_state * root[..., None, None, None]).reshape(*flat, -1)
    b = (by_shared * root[..., None, None, None]).reshape(*flat, -1)
    own = a.transpose(0, 2, 1) @ a + np.einsum("fi,ij->fij", known, np.eye(known.shape[1]))
    return own, a, b, (misses * root[..., None, None]).reshape(flat)
