"""The chain in every frame: least squares to whatever tags the frame shows, camera given."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import Array
from ..seeing.sightings import Sightings
from .bundle import Bundle, corner_residuals, equations, rms


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
    fit: Bundle,
    sightings: Sightings,
    expected: Array,
    expected_sigma_rad: float,
    sensitive: bool = False,
) -> Track:
    """Fit every frame's state.

    expected: (frames, links + 2) where the headings are expected; expected_sigma_rad: how
    well that is known; it decides only about links that no tag holds.
    """
    camera, parts = fit.camera, []
    prior_weight = np.full(expected.shape[1], 1 / expected_sigma_rad**2)
    prior_weight[:2] = 1e-6
    # 400 frames are fitted at once: memory stays small for long films.
    for first in range(0, len(expected), 400):
        cut = slice(first, first + 400)
        s, states, steps = sightings.picked(cut), expected[cut], 6
        while True:
            a, residual = equations(camera, states, s, fit.noise_px)
            matrix = a.transpose(0, 2, 1) @ a + np.diag(prior_weight)
            if not steps:
                break
            pull = a.transpose(0, 2, 1) @ residual
            pull[..., 0] += prior_weight * (expected[cut] - states)
            states = states + np.linalg.solve(matrix, pull)[..., 0]
            steps -= 1
        covariance = np.linalg.inv(matrix)
        variance = np.diagonal(covariance, axis1=1, axis2=2)
        neighbours = np.diagonal(covariance[:, 2:, 2:], offset=1, axis1=1, axis2=2)
        joints = variance[:, 2:-1] + variance[:, 3:] - 2 * neighbours
        rest_px = np.where(s.visible, rms(corner_residuals(camera, states, s)), np.nan)
        part = [states, variance[:, 0] + variance[:, 1], joints, rest_px]
        if sensitive:
            b = equations(camera, states, s, fit.noise_px, shared=True)[1][..., :-1]
            part.append(-np.linalg.solve(matrix, a.transpose(0, 2, 1) @ b))
        parts.append(part)
    return Track(sightings.t_s, *map(np.concatenate, zip(*parts, strict=True)))
