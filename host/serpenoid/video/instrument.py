"""The instrument: from sightings of tags to what the robot did, with standard deviations."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from . import errors
from .arrays import Array, Mask, Places
from .fitting import bundle as bundles
from .fitting import frames, start
from .fitting.camera import Camera
from .fitting.chain import filled_headings, joint_angles
from .motion import Motion, fit_motion
from .seeing.sightings import Sightings

EXPECTED_SIGMA_RAD = np.radians(15.0)  # Sigma of a link without tag, from its neighbours in time.
KNOWN_RAD = np.radians(2.0)  # Sigma of a hidden link's heading by its joints' own sines.


@dataclass(frozen=True)
class Measured:
    """What a film shows.

    bundle: camera and mountings. track: the chain over time. motion: with its residuals.
    sigmas: of `Motion.numbers`. joint_mask: (frames, joints), which joints tags hold.
    """

    bundle: bundles.Bundle
    track: frames.Track
    motion: Motion
    sigmas: Array
    joint_mask: Mask


def _spread(sightings: Sightings, max_count: int) -> Places:
    """Return frames to calibrate with: those with most tags, spread evenly over the film."""
    count = sightings.visible.sum(axis=1)
    frames_with_most = np.flatnonzero(count >= max(2, np.quantile(count, 0.7)))
    order = np.linspace(0, len(frames_with_most) - 1, min(len(frames_with_most), max_count)).round()
    return frames_with_most[order.astype(int)]


def follow(
    sightings: Sightings, side_m: float, starts: list[Camera], rigid: bool = False
) -> tuple[bundles.Bundle, Sightings, frames.Track]:
    """Follow the chain through a film; return camera, frames that show it, and the chain there.

    Camera and mountings are fitted to well-spread frames. starts: those of `start.first_cameras`.
    rigid: the joints do not move, and two tags tell where the robot is. Errors of edges then repeat
    from frame to frame, so that lens and scale are held to what is known before (`rough`).
    """
    sample, rough = sightings.picked(_spread(sightings, 30)), []
    for plane in starts:
        turns = start.quarter_turns(*start.tag_poses(plane, sample))
        camera = plane.with_turns(turns)
        states = start.first_states(camera, sample, turns)
        rough.append(bundles.fit(camera, states, sample, side_m, turns, steps=15, rough=True))
    best = min(rough, key=lambda trial: trial.cost)
    picked = sightings.picked(_spread(sightings, 120))
    states = start.first_states(best.camera, picked, best.turns)
    fit = bundles.fit(best.camera, states, picked, side_m, best.turns, rough=rigid)
    tagged = sightings.picked(sightings.visible.sum(axis=1) >= 1 + rigid)
    expected = start.first_states(fit.camera, tagged, fit.turns)
    return fit, tagged, frames.fit_states(fit, tagged, expected, EXPECTED_SIGMA_RAD)


def fill_hidden(
    fit: bundles.Bundle, tagged: Sightings, track: frames.Track, phi: Array
) -> frames.Track:
    """Return the chain with hidden links where the joints phi say that they point."""
    expected = filled_headings(track.states, tagged.visible, phi)
    return frames.fit_states(fit, tagged, expected, KNOWN_RAD)


def held_joints(track: frames.Track) -> Mask:
    """Return which joints tags hold in which frame, (frames, joints)."""
    return np.asarray(_weights(track)[0] > 0)


def measure(fit: bundles.Bundle, tagged: Sightings, track: frames.Track) -> Measured:
    """Measure what the robot did whose chain was followed."""
    motion, loose_rad = fit_motion(track, *_weights(track)), EXPECTED_SIGMA_RAD
    if not tagged.visible.all():
        phi, loose_rad = joint_angles(track.states) - motion.joint_residual_rad, KNOWN_RAD
        track = fill_hidden(fit, tagged, track, phi)
        motion = fit_motion(track, *_weights(track))
    picked = np.arange(0, len(track.t_s), 1 + len(track.t_s) // 2000)
    sample = tagged.picked(picked), track.states[picked], loose_rad
    sensitive = frames.fit_states(fit, *sample, sensitive=True)
    joint_mask = held_joints(track)
    sigmas = errors.number_sigmas(fit, motion, tagged, sensitive, picked, joint_mask.mean(axis=0))
    return Measured(fit, track, motion, sigmas, joint_mask)


def _weights(track: frames.Track) -> tuple[Array, Array]:
    """Return weights of joints (frames, joints) and of the path (frames,): from the tags there."""
    joints, place = track.joint_variance, track.place_variance
    # Where two tags are missing side by side, the joints there may bend either way.
    missing = np.isnan(track.rest_px)
    pair = np.pad(missing[:, 1:] & missing[:, :-1], ((0, 0), (1, 1)))
    ambiguous = pair[:, :-2] | pair[:, 1:-1] | pair[:, 2:]
    joint_mask = (joints < np.radians(1.5) ** 2) & ~ambiguous
    weight = np.where(joint_mask, np.median(joints) / joints, 0.0)
    return np.minimum(weight, 2.0), np.minimum(np.median(place) / place, 2.0)
