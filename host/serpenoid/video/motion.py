"""Fit rate, joint sines, speed, direction and turn to the track of the chain.

The joints are phi_i = offset_i + sum_k (a_k cos k w t + b_k sin k w t) with one rate w for all;
amplitude and phase are those of k = 1. The path of the robot's centre is z(t) = z_0 + V (e^{i W t}
- 1) / (i W) + e^{i W t} sum_k c_k e^{i k w t}, with the mean velocity V, which turns at the rate W.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..base.sines import HARMONICS, basis, basis_by_rate, fit_sines, weighted
from .arrays import Array, Complex
from .fitting.chain import joint_angles, mean_heading, wrapped
from .fitting.frames import Track


@dataclass(frozen=True)
class Motion:
    """The steady motion of the robot in a film, with residuals; time 0 is the middle of the film.

    omega_rad_s: angular rate of the gait. amplitude_rad, phase_rad, offset_rad: (joints,); phases
    are those of the sines at time 0. velocity_m_s: (2,), mean velocity at time 0. turn_rad_s: rate
    of turn. heading_rad: mean heading of the links at time 0. t_s: (frames,). joint_residual_rad:
    (frames, joints). heading_residual_rad: (frames,). path_residual_m: (frames,), complex. weight,
    path_weight: weights of joints and path in the fit, (frames, joints) and (frames,).
    coefficients: of the joints, (1 + 2 HARMONICS, joints).
    """

    omega_rad_s: float
    amplitude_rad: Array
    phase_rad: Array
    offset_rad: Array
    velocity_m_s: Array
    turn_rad_s: float
    heading_rad: float
    t_s: Array
    joint_residual_rad: Array
    heading_residual_rad: Array
    path_residual_m: Complex
    weight: Array
    path_weight: Array
    coefficients: Array

    @property
    def speed_m_s(self) -> float:
        """Return the mean speed along the path, m/s."""
        return float(np.hypot(*self.velocity_m_s))

    @property
    def direction_rad(self) -> float:
        """Return the direction of travel relative to the mean heading, rad; 0: head first."""
        travel_rad = np.arctan2(self.velocity_m_s[1], self.velocity_m_s[0])
        return float(wrapped(travel_rad - self.heading_rad))

    def numbers(self) -> Array:
        """Return the numbers that have standard uncertainties, in SI.

        They are the rate, the amplitudes, the phases relative to the tail's joint (without its own,
        which is 0), the offsets, direction, speed and turn.
        """
        return np.concatenate(
            [
                [self.omega_rad_s],
                self.amplitude_rad,
                wrapped(self.phase_rad[1:] - self.phase_rad[0]),
                self.offset_rad,
                [self.direction_rad, self.speed_m_s, self.turn_rad_s],
            ]
        )


def first_rate(t_s: Array, phi: Array, weight: Array) -> float:
    """Return the rate, rad/s, at which one sine explains the joints best; 0 if there is none."""
    resolution = 2 * np.pi / (t_s[-1] - t_s[0])
    # No hobby servo reaches 40 rad/s, 6.4 Hz.
    high = min(40.0, 0.9 * np.pi / float(np.median(np.diff(t_s))))
    rates = np.arange(0.6 * resolution, high, 0.1 * resolution)
    explained = []
    for rate in rates:
        columns = basis(t_s, rate, 1)
        explained.append(np.sum(weight * phi * (columns @ weighted(columns, phi, weight))))
    return float(rates[int(np.argmax(explained))]) if len(rates) else 0.0


def sine_covariance(t_s: Array, omega: float, sine: Array, residual: Array, weight: Array) -> Array:
    """Return the covariance of a joint's coefficients and rate, (n, n), n = 2 + 2 HARMONICS.

    sine: the coefficients, (1 + 2 HARMONICS,). residual, weight: (frames,).
    """
    waves = basis(t_s, omega)
    columns = np.column_stack([waves, basis_by_rate(t_s, waves) @ sine])
    a = columns * np.sqrt(weight)[:, None]
    return mean_variance(residual, weight, columns.shape[1]) * np.linalg.pinv(a.T @ a)


def mean_variance(residual: Array, weight: Array, unknowns: int) -> float:
    """Return the variance of weighted residuals, times their correlation_factor.

    unknowns: number of fitted parameters.
    """
    scaled = residual * np.sqrt(weight)
    mask = weight > 0
    free = max(1, int(mask.sum()) - unknowns)
    return float(np.sum(scaled**2) / free) * correlation_factor(scaled[mask])


def path_basis(t_s: Array, omega: float, turn: float) -> Complex:
    """Return the columns (frames, ...) of the path: for z_0, for V, and e^{i (W + k w) t}."""
    rotation = np.exp(1j * turn * t_s)
    straight_rad = 1e-9  # Turn below which the path is straight: the formula divides by it.
    travel = t_s + 0j if abs(turn) * np.ptp(t_s) < straight_rad else (rotation - 1) / (1j * turn)
    orders = [k for k in range(-HARMONICS, HARMONICS + 1) if k]
    waves = [rotation * np.exp(1j * k * omega * t_s) for k in orders]
    return np.stack([np.ones_like(travel), travel, *waves], axis=1)


def fit_motion(
    track: Track, weight: Array, path_weight: Array, omega: float | None = None
) -> Motion:
    """Return the motion fitted to a track.

    weight: of the joints, (frames, joints). path_weight: (frames,). omega: rate from which the fit
    starts, rad/s; None: it is searched for.
    """
    t_s, states = track.t_s - track.t_s.mean(), track.states
    phi = joint_angles(states)
    omega = first_rate(t_s, phi, weight) if omega is None else omega
    omega, sines = fit_sines(t_s, phi, weight, omega)
    heading = mean_heading(states)
    columns = np.column_stack([basis(t_s, omega), t_s])
    headings = weighted(columns, heading[:, None], path_weight[:, None])[:, 0]
    turn = float(headings[-1])
    z, curve = states[:, 0] + 1j * states[:, 1], path_basis(t_s, omega, turn)
    root = np.sqrt(path_weight)
    path = np.linalg.lstsq(curve * root[:, None], z * root, rcond=None)[0]
    return Motion(
        omega,
        np.hypot(sines[1], sines[2]),
        np.arctan2(sines[1], sines[2]),
        sines[0],
        np.array([path[1].real, path[1].imag]),
        turn,
        float(headings[0]),
        t_s,
        phi - basis(t_s, omega) @ sines,
        heading - columns @ headings,
        z - curve @ path,
        weight,
        path_weight,
        sines,
    )


def correlation_factor(residual: Array) -> float:
    """Return the variance of the mean of residuals over that of independent ones.

    It is 1 + 2 times the sum of autocorrelations up to the first pair of neighbouring lags with a
    negative sum (Geyer's initial positive sequence).
    """
    r = residual - residual.mean()
    n = len(r)
    power = np.abs(np.fft.rfft(r, 2 * n)) ** 2
    rho = np.fft.irfft(power)[:n]
    if rho[0] <= 0:
        return 1.0
    rho = rho / rho[0]
    pairs = rho[1 : n // 2 - 1 : 2] + rho[2 : n // 2 : 2]
    is_positive = np.logical_and.accumulate(pairs > 0)
    return 1.0 + 2 * max(float(pairs[is_positive].sum()), float(rho[1:2].sum()), 0.0)
