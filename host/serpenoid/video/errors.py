"""Standard deviations of a film's numbers: what the pixels leave, and what the camera's fit leaves.

Pixels: residuals are taken as they are, slow ones included: the variance of a least-squares fit
times their correlation factor. Camera: each of its unknowns moves the whole track; the motion is
fitted again along each, and the camera's covariance is carried over.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..base.sines import basis
from .arrays import Array, Places
from .fitting.bundle import Bundle
from .fitting.chain import wrapped
from .fitting.frames import Track
from .motion import Motion, fit_motion, mean_variance, path_basis, sine_covariance
from .seeing.sightings import Sightings


def number_sigmas(
    bundle: Bundle,
    motion: Motion,
    sightings: Sightings,
    sample: Track,
    picked: Places,
    joint_shares: Array,
) -> Array:
    """Return the standard deviations of `Motion.numbers`, in their order.

    sample: the track in the frames `picked`, with how it follows the camera's unknowns.
    joint_shares: of the frames, in which each joint is known.
    """
    amplitude, count = motion.amplitude_rad, len(motion.amplitude_rad)
    # What a slow readout does, which to first order is allowed for: each joint's part of it, as a
    # phase; and the share of speed and rate that it takes off or adds.
    readout_s, height = bundle.camera.readout_s, sightings.image_px[1]
    rows = np.ma.masked_invalid(sightings.corners_px[..., 1]).mean(axis=(0, 2)) / height - 0.5
    delay = readout_s * motion.omega_rad_s * 0.5 * (rows[1:] + rows[:-1])
    first, last = bundle.camera.plane_px(sample.states[[0, -1], :2])[:, 1] / height
    delay_rad, sweep = np.ma.filled(delay, 0.0), readout_s * (last - first) / np.ptp(sample.t_s)
    # A codec draws each picture on the one before, and takes a little of the motion: amplitudes
    # come out low (rendered films coded at crf 20; not coded at crf 1). By .07 % for tags of 28 px,
    # .14 % of 20 px, .17 % of 15 px: what is lost in pixels grows as tags get small beside the
    # codec's blocks, and the angle is that over the tag's side.
    coded = max(1.0, (28.0 / float(np.nanmedian(sightings.side_px))) ** 2)
    # No phone was ever held against a rule: the lens is not the two terms of the model. Of the
    # readout's sweep rendered films leave .05 in the rate and .2 in the speed.
    floor = [
        [0.05 * sweep * motion.omega_rad_s],
        coded * np.hypot(np.radians(0.02), 6e-4 * amplitude),
        np.full(count - 1, np.radians(0.03)),
        np.full(count, np.radians(0.01)),  # A centre is a mean: it has no share of what moves.
        [np.radians(0.03), np.hypot(1.5e-4, 0.2 * sweep) * motion.speed_m_s, np.radians(0.003)],
    ]
    camera = _of_camera(bundle, sample, motion, picked)
    sigmas = np.sqrt(_of_pixels(motion) ** 2 + camera**2 + np.concatenate(floor) ** 2)
    # What a slow readout and missing tags leave, of amplitudes and phases: .02 of the readout's
    # phase is left by rows along the travel (rendered films).
    phase_shares = np.minimum(joint_shares[1:], joint_shares[0])
    lags = [0.5 * delay_rad**2 * amplitude, 0.02 * (delay_rad[1:] - delay_rad[0])]
    joints = slice(1, 2 * count)
    sigmas[joints] = np.hypot(sigmas[joints], np.concatenate(lags))
    sigmas[joints] /= np.maximum(np.concatenate([joint_shares, phase_shares]), 0.1)
    return sigmas


def _of_pixels(motion: Motion) -> Array:
    """Return what the residuals of joints and path leave open."""
    m = motion
    amplitude, phase, offset, rate = np.zeros((4, len(m.phase_rad)))
    columns = m.coefficients.T, m.joint_residual_rad.T, m.weight.T, m.phase_rad
    for i, (sine, residual, weight, phase_rad) in enumerate(zip(*columns, strict=True)):
        cov = sine_covariance(m.t_s, m.omega_rad_s, sine, residual, weight)
        s, c = np.sin(phase_rad), np.cos(phase_rad)
        rotated = np.array([[s, c], [c, -s]])
        amplitude[i], phase[i] = np.sqrt(np.diag(rotated @ cov[1:3, 1:3] @ rotated.T))
        offset[i], rate[i] = np.sqrt(np.diag(cov)[[0, -1]])
    phase /= np.maximum(m.amplitude_rad, 1e-9)
    omega = 1 / np.sqrt(np.sum(1 / np.maximum(rate, 1e-12) ** 2))
    weight = motion.path_weight
    root = np.sqrt(weight)[:, None]
    a = path_basis(motion.t_s, m.omega_rad_s, m.turn_rad_s) * root
    rotation = np.exp(-1j * np.arctan2(m.velocity_m_s[1], m.velocity_m_s[0]))
    along_path = motion.path_residual_m * rotation
    b = np.column_stack([basis(motion.t_s, m.omega_rad_s), motion.t_s]) * root
    spread = np.linalg.pinv((a.conj().T @ a).real)[1, 1]
    along, across, turn = (
        np.sqrt(mean_variance(residual, weight, unknowns) * factor)
        for residual, unknowns, factor in (
            (along_path.real, 5, spread),
            (along_path.imag, 5, spread),
            (motion.heading_residual_rad, 8, np.linalg.pinv(b.T @ b)[-1, -1]),
        )
    )
    direction = across / max(m.speed_m_s, 1e-9)
    lags = np.hypot(phase[1:], phase[0])
    return np.concatenate([[omega], amplitude, lags, offset, [direction, along, turn]])


def _of_camera(bundle: Bundle, track: Track, motion: Motion, picked: Places) -> Array:
    """Return what the camera's covariance leaves open.

    Along the covariance's own directions: focal length and distance alone bend the track by many
    degrees, together by hundredths.
    """
    assert track.by_shared is not None
    step = 0.3  # Difference, in standard deviations, by which the camera's doubt is carried on.
    weights = motion.weight[picked], motion.path_weight[picked]

    def numbers(states: Array) -> Array:
        moved_track = replace(track, states=states)
        return fit_motion(moved_track, *weights, motion.omega_rad_s).numbers()

    scale = np.sqrt(np.diag(bundle.covariance))
    values, vectors = np.linalg.eigh(bundle.covariance / np.outer(scale, scale))
    sizes, directions = np.sqrt(np.maximum(values, 0.0)), scale[:, None] * vectors
    base = numbers(track.states)
    variance = np.zeros(len(base))
    for size, direction in zip(sizes, directions.T, strict=True):
        change = numbers(track.states + step * size * (track.by_shared @ direction)) - base
        change[1:-2] = wrapped(change[1:-2])
        variance += (change / step) ** 2
    return np.sqrt(variance)
