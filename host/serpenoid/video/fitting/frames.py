"""The chain in every frame: least squares to whatever tags the frame shows, camera given."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import Array
from ..seeing.sightings import Sightings, in_chunks
from .bundle import Bundle, equations, misses, rms

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

    def of_frames(cut: slice) -> tuple[Array, ...]:
        s, expected_state = sightings.picked(cut), expected[cut]
        prior_weight = np.zeros_like(expected_state)
        prior_weight[:, 2:] = 1 / expected_sigma_rad**2
        prior_weight[:, :2] = 1e-6
        prior_matrix = prior_weight[:, None] * np.eye(prior_weight.shape[1])
        camera, states = fit.camera, expected_state
        a, residual = equations(camera, states, s, fit.noise_px)
        for _ in range(STEPS):
            pull = (a.transpose(0, 2, 1) @ residual)[..., 0] + prior_weight * (
                expected_state - states
            )
            step = np.linalg.solve(a.transpose(0, 2, 1) @ a + prior_matrix, pull[..., None])
            states = states + step[..., 0]
            a, residual = equations(camera, states, s, fit.noise_px)
        matrix = a.transpose(0, 2, 1) @ a + prior_matrix
        rest_px = np.where(s.visible, rms(misses(camera, states, s)), np.nan)
        covariance = np.linalg.inv(matrix)
        variance = np.diagonal(covariance, axis1=1, axis2=2)
        neighbours = np.diagonal(covariance[:, 2:, 2:], offset=1, axis1=1, axis2=2)
        joints = variance[:, 2:-1] + variance[:, 3:] - 2 * neighbours
        fitted = states, variance[:, 0] + variance[:, 1], joints, rest_px
        if not sensitive:
            return fitted
        b = equations(camera, states, s, fit.noise_px, shared=True)[1][..., :-1]
        return (*fitted, -np.linalg.solve(matrix, a.transpose(0, 2, 1) @ b))

    return Track(sightings.t_s, *in_chunks(of_frames, len(expected)))
