"""Standard uncertainties of the numbers that are measured in a film.

Errors of single pixels: the variance of the least-squares fit of the motion, times a factor for the
correlation of the residuals. Errors of the fitted camera: its covariance is propagated by fitting
the motion again to tracks that are moved along its principal directions. Systematic errors of
cameras and codecs: lower bounds that were found with rendered films.
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
    """Return the standard uncertainties of `Motion.numbers`, in their order.

    sample: the track in the frames `picked`, with its derivatives by the camera's parameters.
    joint_shares: (joints,), share of the frames in which each joint is known.
    """
    amplitude, count = motion.amplitude_rad, len(motion.amplitude_rad)
    # A rolling shutter reads the rows of a frame one after the other. The fit corrects this to
    # first order; the size of the correction is a phase of each joint, and a relative change of
    # speed and rate (sweep).
    readout_s, height = bundle.camera.readout_s, sightings.image_px[1]
    rows = np.ma.masked_invalid(sightings.corners_px[..., 1]).mean(axis=(0, 2)) / height - 0.5
    delay = readout_s * motion.omega_rad_s * 0.5 * (rows[1:] + rows[:-1])
    first, last = bundle.camera.plane_px(sample.states[[0, -1], :2])[:, 1] / height
    delay_rad, sweep = np.ma.filled(delay, 0.0), readout_s * (last - first) / np.ptp(sample.t_s)
    # A codec predicts each frame from the one before and loses a little of the motion. In rendered
    # films at crf 20 amplitudes come out low by 0.07 % with tags of 28 px, 0.14 % with 20 px and
    # 0.17 % with 15 px; at crf 1 they do not.
    codec_factor = max(1.0, (28.0 / float(np.nanmedian(sightings.side_px))) ** 2)
    # Smallest uncertainties, since the lens of a phone has more than the model's two terms. In
    # rendered films 0.05 of the sweep remains as an error of the rate, and 0.2 of it in the speed.
    floor = [
        [0.05 * sweep * motion.omega_rad_s],
        codec_factor * np.hypot(np.radians(0.02), 6e-4 * amplitude),
        np.full(count - 1, np.radians(0.03)),
        np.full(count, np.radians(0.01)),  # The mean angle does not suffer from the codec.
        [np.radians(0.03), np.hypot(1.5e-4, 0.2 * sweep) * motion.speed_m_s, np.radians(0.003)],
    ]
    camera = _camera_sigmas(bundle, sample, motion, picked)
    sigmas = np.sqrt(_pixel_sigmas(motion) ** 2 + camera**2 + np.concatenate(floor) ** 2)
    # Uncertainties of amplitudes and phases from the rolling shutter, of whose phase 0.02 remains
    # in rendered films, and from frames in which tags are missing.
    phase_shares = np.minimum(joint_shares[1:], joint_shares[0])
    lags = [0.5 * delay_rad**2 * amplitude, 0.02 * (delay_rad[1:] - delay_rad[0])]
    joints = slice(1, 2 * count)
    sigmas[joints] = np.hypot(sigmas[joints], np.concatenate(lags))
    sigmas[joints] /= np.maximum(np.concatenate([joint_shares, phase_shares]), 0.1)
    return sigmas


def _pixel_sigmas(motion: Motion) -> Array:
    """Return the standard uncertainties from the residuals of joints and path."""
    t_s, omega_rad_s = motion.t_s, motion.omega_rad_s
    amplitude, phase, offset, rate = np.zeros((4, len(motion.phase_rad)))
    columns = motion.coefficients.T, motion.joint_residual_rad.T, motion.weight.T, motion.phase_rad
    for joint, (sine, residual, weight, phase_rad) in enumerate(zip(*columns, strict=True)):
        covariance = sine_covariance(t_s, omega_rad_s, sine, residual, weight)
        sin, cos = np.sin(phase_rad), np.cos(phase_rad)
        # Derivatives of amplitude, and of phase times amplitude, by the two coefficients.
        polar = np.array([[sin, cos], [cos, -sin]])
        variances = np.diag(polar @ covariance[1:3, 1:3] @ polar.T)
        amplitude[joint], phase[joint] = np.sqrt(variances)
        offset[joint], rate[joint] = np.sqrt(np.diag(covariance)[[0, -1]])
    phase /= np.maximum(motion.amplitude_rad, 1e-9)
    omega = 1 / np.sqrt(np.sum(1 / np.maximum(rate, 1e-12) ** 2))
    weight = motion.path_weight
    root = np.sqrt(weight)[:, None]
    path = path_basis(t_s, omega_rad_s, motion.turn_rad_s) * root
    heading = np.column_stack([basis(t_s, omega_rad_s), t_s]) * root
    rotation = np.exp(-1j * np.arctan2(motion.velocity_m_s[1], motion.velocity_m_s[0]))
    along_path = motion.path_residual_m * rotation
    path_inverse = np.linalg.pinv((path.conj().T @ path).real)[1, 1]
    heading_inverse = np.linalg.pinv(heading.T @ heading)[-1, -1]
    along, across, turn = (
        np.sqrt(mean_variance(residual, weight, parameters) * inverse)
        for residual, parameters, inverse in (
            (along_path.real, 5, path_inverse),
            (along_path.imag, 5, path_inverse),
            (motion.heading_residual_rad, 8, heading_inverse),
        )
    )
    direction = across / max(motion.speed_m_s, 1e-9)
    lags = np.hypot(phase[1:], phase[0])
    return np.concatenate([[omega], amplitude, lags, offset, [direction, along, turn]])


def _camera_sigmas(bundle: Bundle, track: Track, motion: Motion, picked: Places) -> Array:
    """Return the standard uncertainties from the covariance of the camera's parameters.

    The track is moved along the eigenvectors of their correlation: focal length and distance alone
    bend the track by many degrees, together by hundredths.
    """
    assert track.by_shared is not None
    step = 0.3  # Difference for the derivatives, in standard deviations.
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
