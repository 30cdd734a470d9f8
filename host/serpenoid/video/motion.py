"""From the chain over time to numbers: rate, every joint's sine, speed, direction and turn.

Joints: phi_i = offset_i + sum_k (a_k cos k w t + b_k sin k w t), one rate w for all; amplitude and
phase are those of k = 1. Path: z(t) = z_0 + V (e^{i W t} - 1) / (i W) + e^{i W t} sum_k c_k
e^{i k w t}: the middle of the robot goes at the mean velocity V, which turns at the rate W.
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
    """What the robot did, steady over the film, with what is left over.

    omega_rad_s; amplitude_rad, phase_rad, offset_rad (joints,), phase of the sine at time 0;
    velocity_m_s (2,): mean at time 0, in the plane; turn_rad_s; heading_rad: mean of the links' at
    time 0. Time 0 is the middle of the film, as in t_s (frames,). Residuals of joints (frames,
    joints), mean heading (frames,) rad, and path (frames,) m; the weights of joints and of the
    path; the joints' coefficients (1 + 2 HARMONICS, joints).
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
        """Return the mean speed along the path."""
        return float(np.hypot(*self.velocity_m_s))

    @property
    def direction_rad(self) -> float:
        """Return the direction of travel from where the links point in the mean; 0: head first."""
        way = np.arctan2(self.velocity_m_s[1], self.velocity_m_s[0]) - self.heading_rad
        return float(wrapped(way))

    def numbers(self) -> Array:
        """Return what errors are wanted of.

        Rate, amplitudes, phases beside the tail joint's, offsets, direction, speed, turn.
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
    """Return the rate at which one sine explains most of the joints, rad/s; 0 for none."""
    unit = 2 * np.pi / (t_s[-1] - t_s[0])
    # A rate of 40 rad/s, 6.4 Hz, is beyond any hobby servo.
    high = min(40.0, 0.9 * np.pi / float(np.median(np.diff(t_s))))
    rates = np.arange(0.6 * unit, high, 0.1 * unit)
    explained = []
    for rate in rates:
        columns = basis(t_s, rate, 1)
        explained.append(np.sum(weight * phi * (columns @ weighted(columns, phi, weight))))
    return float(rates[int(np.argmax(explained))]) if len(rates) else 0.0


def sine_covariance(t_s: Array, omega: float, sine: Array, residual: Array, weight: Array) -> Array:
    """Return the covariance of a joint's coefficients and its rate, (2 + 2 HARMONICS,) squared.

    sine: the coefficients; rest: what they leave, (frames,).
    """
    waves = basis(t_s, omega)
    columns = np.column_stack([waves, basis_by_rate(t_s, waves) @ sine])
    a = columns * np.sqrt(weight)[:, None]
    return mean_variance(residual, weight, columns.shape[1]) * np.linalg.pinv(a.T @ a)


def mean_variance(residual: Array, weight: Array, unknowns: int) -> float:
    """Return the weighted residuals' variance, times the factor of their correlation."""
    scaled = residual * np.sqrt(weight)
    mask = weight > 0
    free = max(1, int(mask.sum()) - unknowns)
    return float(np.sum(scaled**2) / free) * correlation_factor(scaled[mask])


def path_basis(t_s: Array, omega: float, turn: float) -> Complex:
    """Return the columns of the path's formula: 1, V's, then e^{i (W + k w) t}."""
    rotation = np.exp(1j * turn * t_s)
    straight_rad = 1e-9  # Turn over the film below which it is none: the formula divides by it.
    travel = t_s + 0j if abs(turn) * np.ptp(t_s) < straight_rad else (rotation - 1) / (1j * turn)
    orders = [k for k in range(-HARMONICS, HARMONICS + 1) if k]
    waves = [rotation * np.exp(1j * k * omega * t_s) for k in orders]
    return np.stack([np.ones_like(travel), travel, *waves], axis=1)


def fit_motion(
    track: Track, weight: Array, path_weight: Array, omega: float | None = None
) -> Motion:
    """Fit rate, sines, path and turn to a track.

    weight (frames, joints) of the joints, path_weight (frames,). omega: the rate to start from.
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
    """Return by how much the variance of a mean of such residuals exceeds that of independent ones.

    1 + 2 sum of autocorrelations, summed in pairs while these are above 0.
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
