"""Standard deviations of a film's numbers: what the pixels leave, and what the camera's fit leaves.

Pixels: residuals are taken as they are, slow ones included: the variance of a least-squares fit
times their correlation factor. Camera: each of its unknowns moves the whole track; the motion is
fitted again along each, and the camera's covariance is carried over.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .fitting.bundle import Bundle
from .fitting.chain import joint_angles
from .fitting.frames import Track
from .motion import Fitted, basis, correlation_factor, fit_from, joint_slope, path_basis

Array = NDArray[np.float64]
# Below these no phone was ever held against a rule: the lens is not the two terms of the model.
STEP = 0.3  # of a standard deviation: the differences by which the camera's doubt is carried on
FLOOR_SPEED, FLOOR_ANGLE_RAD, FLOOR_TURN_RAD_S = 1.5e-4, np.radians(0.03), np.radians(0.003)
LATE = 0.02  # share of the readout's phase that rows along the travel leave (rendered films)
FLOOR_OFFSET_RAD = np.radians(0.01)  # a centre is a mean: it has no share of what moves
# A codec draws each picture on the one before, and takes a little of the motion: amplitudes come
# out low (rendered films coded at crf 20; not coded at crf 1). By .07 % for tags of 28 px, .14 % of
# 20 px, .17 % of 15 px: what is lost in pixels grows as tags get small beside the codec's blocks,
# and the angle is that over the tag's side.
FLOOR_AMPLITUDE, FLOOR_AMPLITUDE_RAD, CODED_PX = 6e-4, np.radians(0.02), 28.0


def number_sigmas(
    bundle: Bundle,
    t_s: Array,
    fitted: Fitted,
    some: Track,
    picked: NDArray[np.int64],
    side_px: float,
    rate_sigma: float | None = None,
) -> Array:
    """Return the standard deviations of `Motion.numbers`, in their order.

    t_s: times of all frames. some: the track in the frames `picked`, with how it follows the
    camera's unknowns. side_px: of a tag. rate_sigma: of the rate, rad/s, where joints were assumed;
    theirs else.
    """
    pixels = _of_pixels(t_s, fitted)
    if rate_sigma is not None:
        pixels[0] = rate_sigma
    camera = _of_camera(bundle, some, fitted, picked)
    floor = np.full(len(pixels), FLOOR_ANGLE_RAD)
    floor[0], floor[-1] = 0.0, FLOOR_TURN_RAD_S
    floor[-2] = FLOOR_SPEED * fitted.motion.speed_m_s
    amplitude = fitted.motion.amplitude_rad
    floor[2 * len(amplitude) : 3 * len(amplitude)] = FLOOR_OFFSET_RAD
    coded = max(1.0, (CODED_PX / side_px) ** 2)
    lag = coded * np.hypot(FLOOR_AMPLITUDE_RAD, FLOOR_AMPLITUDE * amplitude)
    floor[1 : 1 + len(amplitude)] = lag
    return np.sqrt(pixels**2 + camera**2 + floor**2)


def widen(sigmas: Array, amplitude: Array, late_rad: Array, held: Array) -> None:
    """Widen, in place, what a slow readout and missing tags leave of `Motion.numbers`.

    late_rad: each joint's part of the readout, as a phase; to first order it is allowed for. held:
    share of the frames that tell a joint.
    """
    count = len(amplitude)
    own, apart = slice(1, count + 1), slice(count + 1, 2 * count)
    sigmas[own] = np.hypot(sigmas[own], 0.5 * late_rad**2 * amplitude)
    sigmas[apart] = np.hypot(sigmas[apart], LATE * (late_rad[1:] - late_rad[0]))
    sigmas[own] /= np.maximum(held, 0.1)
    sigmas[apart] /= np.maximum(np.minimum(held[1:], held[0]), 0.1)


def _of_pixels(t_s: Array, fitted: Fitted) -> Array:
    """Return what the residuals of joints and path leave open."""
    t = t_s - t_s.mean()
    m = fitted.motion
    columns = basis(t, m.omega_rad_s)
    joints = fitted.joints_rest_rad.shape[1]
    amplitude, phase, offset, rate = (np.zeros(joints) for _ in range(4))
    for i in range(joints):
        variance, free = _variance(fitted.joints_rest_rad[:, i], fitted.weight[:, i], 8)
        slope = joint_slope(t, fitted, i)
        a = np.concatenate([columns, slope[:, None]], axis=1) * np.sqrt(fitted.weight[:, i, None])
        cov = variance * np.linalg.pinv(a.T @ a) * free
        s, c = np.sin(m.phase_rad[i]), np.cos(m.phase_rad[i])
        offset[i] = np.sqrt(cov[0, 0])
        along = np.zeros(len(cov))
        along[1:3] = s, c
        amplitude[i] = np.sqrt(along @ cov @ along)
        along[1:3] = c, -s
        phase[i] = np.sqrt(along @ cov @ along) / max(m.amplitude_rad[i], 1e-9)
        rate[i] = np.sqrt(cov[-1, -1])
    apart = np.hypot(phase[1:], phase[0])
    omega = 1 / np.sqrt(np.sum(1 / np.maximum(rate, 1e-12) ** 2))
    along, across, turn = _of_path(t, fitted)
    direction = across / max(m.speed_m_s, 1e-9)
    return np.concatenate([[omega], amplitude, apart, offset, [direction, along, turn]])


def _variance(rest: Array, weight: Array, unknowns: int) -> tuple[float, float]:
    """Return the weighted residuals' variance and the factor of their correlation."""
    scaled = rest * np.sqrt(weight)
    there = weight > 0
    free = max(1, int(there.sum()) - unknowns)
    return float(np.sum(scaled**2) / free), correlation_factor(scaled[there])


def _of_path(t: Array, fitted: Fitted) -> tuple[float, float, float]:
    """Return sigma of the velocity along and across the path, and of the turn's rate."""
    m = fitted.motion
    weight = fitted.path_weight
    a = path_basis(t, m.omega_rad_s, m.turn_rad_s) * np.sqrt(weight)[:, None]
    way = np.exp(-1j * np.arctan2(m.velocity_m_s[1], m.velocity_m_s[0]))
    rest = fitted.path_rest_m * way
    cov = np.linalg.pinv((a.conj().T @ a).real)[1, 1]
    sigmas = [np.sqrt(np.prod(_variance(part, weight, 5)) * cov) for part in (rest.real, rest.imag)]
    columns = np.concatenate([basis(t, m.omega_rad_s), t[:, None]], axis=1)
    b = columns * np.sqrt(weight)[:, None]
    spread, slow = _variance(fitted.heading_rest_rad, weight, 8)
    turn = np.sqrt(spread * slow * np.linalg.pinv(b.T @ b)[-1, -1])
    return float(sigmas[0]), float(sigmas[1]), float(turn)


def _of_camera(bundle: Bundle, track: Track, fitted: Fitted, picked: NDArray[np.int64]) -> Array:
    """Return what the camera's covariance leaves open.

    Along the covariance's own directions: focal length and distance alone bend the track by many
    degrees, together by hundredths.
    """
    assert track.by_shared is not None
    t = track.t_s - track.t_s.mean()

    def numbers(states: Array) -> Array:
        phi = joint_angles(states)
        weights = fitted.weight[picked], fitted.path_weight[picked]
        return fit_from(t, states, phi, *weights, fitted.motion.omega_rad_s).motion.numbers()

    sizes, directions = _own_directions(bundle.covariance)
    here = numbers(track.states)
    variance = np.zeros(len(here))
    for size, direction in zip(sizes, directions.T, strict=True):
        change = numbers(track.states + STEP * size * (track.by_shared @ direction)) - here
        change[1:-2] = (change[1:-2] + np.pi) % (2 * np.pi) - np.pi
        variance += (change / STEP) ** 2
    return np.sqrt(variance)


def _own_directions(covariance: Array) -> tuple[Array, Array]:
    """Return sizes and directions (columns) whose squares add up to a covariance."""
    scale = np.sqrt(np.diag(covariance))
    values, vectors = np.linalg.eigh(covariance / np.outer(scale, scale))
    return np.sqrt(np.maximum(values, 0.0)), scale[:, None] * vectors
