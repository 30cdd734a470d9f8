"""The instrument: from sightings of tags to what the robot did, with standard deviations."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from . import errors, motion
from .fitting import bundle as bundles
from .fitting import frames, start
from .seeing.sightings import Sightings

Array = NDArray[np.float64]
CALIBRATION_FRAMES = 120
ROUGH_FRAMES, ROUGH_STEPS = 30, 15  # for the choice between starts
EXPECTED_SIGMA_RAD = np.radians(15.0)  # of a link that no tag holds, from its neighbours in time
SENSITIVE_FRAMES = 2000  # at most, for how the track follows the camera
HELD_RAD = np.radians(1.5)  # a joint known worse than this in a frame says nothing there


@dataclass(frozen=True)
class Measured:
    """What a film shows.

    bundle: camera and mountings. track: the chain over time. fitted: motion and residuals.
    sigmas: of `Motion.numbers`. held: which joints tags hold in which frame, (frames, joints).
    """

    bundle: bundles.Bundle
    track: frames.Track
    fitted: motion.Fitted
    sigmas: Array
    held: NDArray[np.bool_]


def calibrate(sightings: Sightings, link_m: float, side_m: float) -> tuple[bundles.Bundle, Array]:
    """Fit camera and mountings to well-spread frames; return them and the quarter turns."""
    few = sightings.picked(_spread(sightings, ROUGH_FRAMES))
    rough = []
    for plane in start.first_cameras(few, link_m, side_m):
        turns = start.quarter_turns(*start.tag_poses(plane, few))
        camera = plane.with_turns(turns)
        states = start.first_states(camera, few, turns)
        found, _ = bundles.fit(camera, states, few, side_m, turns, ROUGH_STEPS, rough=True)
        rough.append((found.cost, found.camera, turns))
    _, camera, turns = min(rough, key=lambda tried: tried[0])
    picked = sightings.picked(_spread(sightings, CALIBRATION_FRAMES))
    states = start.first_states(camera, picked, turns)
    return bundles.fit(camera, states, picked, side_m, turns)[0], turns


def _spread(sightings: Sightings, most: int) -> NDArray[np.int64]:
    """Return frames to calibrate with: those with most tags, spread evenly over the film."""
    count = sightings.seen.sum(axis=1)
    good = np.flatnonzero(count >= max(2, np.quantile(count, 0.7)))
    order = np.linspace(0, len(good) - 1, min(len(good), most)).round()
    return good[order.astype(int)]


def measure(sightings: Sightings, link_m: float, side_m: float) -> Measured:
    """Measure what the robot did in a film."""
    fit, turns = calibrate(sightings, link_m, side_m)
    seen = sightings.picked(np.asarray(sightings.seen.any(axis=1)))
    expected = start.first_states(fit.camera, seen, turns)
    loose = np.full(len(expected), EXPECTED_SIGMA_RAD)
    track = frames.fit_states(fit.camera, seen, expected, loose, fit.noise_px)
    fitted = _motion_of(track)
    track = frames.fit_states(fit.camera, seen, track.states, loose, fit.noise_px)
    fitted = _motion_of(track)
    some = _sensitive(fit, seen, track, loose)
    sigmas = errors.number_sigmas(fit, some, _motion_of(some))
    return Measured(fit, track, fitted, sigmas, _weights(track)[0] > 0)


def _sensitive(
    fit: bundles.Bundle, seen: Sightings, track: frames.Track, loose: Array
) -> frames.Track:
    some = np.arange(0, len(track.t_s), 1 + len(track.t_s) // SENSITIVE_FRAMES)
    return frames.fit_states(
        fit.camera, seen.picked(some), track.states[some], loose[some], fit.noise_px, sensitive=True
    )


def _weights(track: frames.Track) -> tuple[Array, Array]:
    """Return weights of joints (frames, joints) and of the path (frames,): from the tags there."""
    cov = track.covariance
    own = np.diagonal(cov, axis1=1, axis2=2)
    lag = np.diagonal(cov[:, 2:, 2:], offset=1, axis1=1, axis2=2)
    joints = own[:, 2:-1] + own[:, 3:] - 2 * lag
    weight = np.where(joints < HELD_RAD**2, np.median(joints) / joints, 0.0)
    place = own[:, 0] + own[:, 1]
    return np.minimum(weight, 2.0), np.minimum(np.median(place) / place, 2.0)


def _motion_of(track: frames.Track) -> motion.Fitted:
    return motion.fit_motion(track, *_weights(track))
