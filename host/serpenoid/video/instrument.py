"""The instrument: from sightings of tags to what the robot did, with standard deviations."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from . import errors, motion, unseen
from .arrays import Array, Mask, Places
from .fitting import bundle as bundles
from .fitting import frames, start
from .fitting.camera import Camera
from .fitting.chain import filled_headings, joint_angles
from .seeing.sightings import Sightings

CALIBRATION_FRAMES = 120
ROUGH_FRAMES, ROUGH_STEPS = 30, 15  # for the choice between starts
EXPECTED_SIGMA_RAD = np.radians(15.0)  # of a link that no tag holds, from its neighbours in time
SENSITIVE_FRAMES = 2000  # at most, for how the track follows the camera
HELD_SHARE = 0.15  # of the frames: a joint seen less is taken from the gait
GAIT_ROUNDS, GAIT_RAD = 2, np.radians(15.0)  # how well one sine says where a link points
HELD_RAD = np.radians(1.5)  # a joint known worse than this in a frame says nothing there


@dataclass(frozen=True)
class Measured:
    """What a film shows.

    bundle: camera and mountings. track: the chain over time. fitted: motion and residuals.
    sigmas: of `Motion.numbers`. held: which joints tags hold in which frame, (frames, joints).
    assumed: some joints are never seen, and follow one travelling sine.
    """

    bundle: bundles.Bundle
    track: frames.Track
    fitted: motion.Fitted
    sigmas: Array
    held: Mask
    assumed: bool = False


def calibrate(
    sightings: Sightings, side_m: float, starts: list[Camera], still: bool = False
) -> tuple[bundles.Bundle, Array]:
    """Fit camera and mountings to well-spread frames; return them and the quarter turns.

    still: the joints do not move. Errors of edges then repeat from frame to frame, so that lens and
    scale are held to what is known before (`rough`).
    """
    few = sightings.picked(_spread(sightings, ROUGH_FRAMES))
    rough = []
    for plane in starts:
        turns = start.quarter_turns(*start.tag_poses(plane, few))
        camera = plane.with_turns(turns)
        states = start.first_states(camera, few, turns)
        fitted = bundles.fit(camera, states, few, side_m, turns, ROUGH_STEPS, rough=True)
        rough.append((fitted.cost, fitted.camera, turns))
    _, camera, turns = min(rough, key=lambda tried: tried[0])
    picked = sightings.picked(_spread(sightings, CALIBRATION_FRAMES))
    states = start.first_states(camera, picked, turns)
    return bundles.fit(camera, states, picked, side_m, turns, rough=still), turns


def _spread(sightings: Sightings, most: int) -> Places:
    """Return frames to calibrate with: those with most tags, spread evenly over the film."""
    count = sightings.seen.sum(axis=1)
    good = np.flatnonzero(count >= max(2, np.quantile(count, 0.7)))
    order = np.linspace(0, len(good) - 1, min(len(good), most)).round()
    return good[order.astype(int)]


def measure(sightings: Sightings, side_m: float, starts: list[Camera]) -> Measured:
    """Measure what the robot did in a film. starts: those of `start.first_cameras`."""
    fit, turns = calibrate(sightings, side_m, starts)
    seen = sightings.picked(np.asarray(sightings.seen.any(axis=1)))
    expected = start.first_states(fit.camera, seen, turns)
    loose_rad = EXPECTED_SIGMA_RAD
    track = frames.fit_states(fit.camera, seen, expected, loose_rad, fit.noise_px)
    # A joint that is held so seldom has no sine to be fitted.
    assumed = bool((_weights(track)[0] > 0).mean(axis=0).min() < HELD_SHARE)
    for _ in range(GAIT_ROUNDS if assumed else 0):
        fit, track = _by_the_gait(fit, seen, expected, side_m, turns)
        expected = track.states
    rate = None
    if assumed:  # that of the bend between the outermost tags
        first, last = unseen.outermost(seen)
        both = seen.seen[:, first] & seen.seen[:, last]
        bend = np.unwrap((track.states[:, 2 + last] - track.states[:, 2 + first])[both])
        rate = motion.bend_rate((track.t_s - track.t_s.mean())[both], bend)
    fitted = _motion_of(track, rate)
    if not seen.seen.all():
        phi = joint_angles(track.states) - fitted.joints_rest_rad
        expected = filled_headings(track.states, seen.seen, phi)
        loose_rad = unseen.KNOWN_RAD
        track = frames.fit_states(fit.camera, seen, expected, loose_rad, fit.noise_px)
        fitted = _motion_of(track, rate)
    some = np.arange(0, len(track.t_s), 1 + len(track.t_s) // SENSITIVE_FRAMES)
    few = seen.picked(some), track.states[some], loose_rad
    sensitive = frames.fit_states(fit.camera, *few, fit.noise_px, sensitive=True)
    rate_sigma = None if rate is None else rate[1]
    held = _weights(track)[0] > 0
    sigmas = errors.number_sigmas(fit, fitted, seen, sensitive, some, held.mean(axis=0), rate_sigma)
    return Measured(fit, track, fitted, sigmas, held, assumed)


def _by_the_gait(
    fit: bundles.Bundle, seen: Sightings, expected: Array, side_m: float, turns: Array
) -> tuple[bundles.Bundle, frames.Track]:
    """Fit camera and track anew, with unseen links where one travelling sine has them."""
    picked = _spread(seen, CALIBRATION_FRAMES)
    phi = unseen.travelling_sine(fit.camera, seen, turns)
    guess = filled_headings(expected, seen.seen, phi)
    few = seen.picked(picked)
    fit = bundles.fit(fit.camera, guess[picked], few, side_m, turns, known_rad=GAIT_RAD)
    return fit, frames.fit_states(fit.camera, seen, guess, GAIT_RAD, fit.noise_px)


def _weights(track: frames.Track) -> tuple[Array, Array]:
    """Return weights of joints (frames, joints) and of the path (frames,): from the tags there."""
    joints, place = track.joint_variance, track.place_variance
    # Where two tags are missing side by side, the joints there may bend either way.
    missing = np.isnan(track.rest_px)
    pair = np.pad(missing[:, 1:] & missing[:, :-1], ((0, 0), (1, 1)))
    ambiguous = pair[:, :-2] | pair[:, 1:-1] | pair[:, 2:]
    held = (joints < HELD_RAD**2) & ~ambiguous
    weight = np.where(held, np.median(joints) / joints, 0.0)
    return np.minimum(weight, 2.0), np.minimum(np.median(place) / place, 2.0)


def _motion_of(track: frames.Track, rate: tuple[float, float] | None = None) -> motion.Fitted:
    """Fit the motion; rate: with its sigma, where joints are not seen but assumed."""
    joints, path = _weights(track)
    if rate is None:
        return motion.fit_motion(track, joints, path)
    return motion.fit_motion(track, np.ones_like(joints), path, rate[0], free_rate=False)
