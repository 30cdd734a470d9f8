"""From the chain over time to numbers: rate, every joint's sine, speed, direction and turn.

Joints: phi_i = offset_i + sum_k (a_k cos k w t + b_k sin k w t), one rate w for all; amplitude and
phase are those of k = 1. Path: z(t) = z_0 + V (e^{i W t} - 1) / (i W) + e^{i W t} sum_k c_k
e^{i k w t}: the middle of the robot goes at the mean velocity V, which turns at the rate W.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .fitting.chain import joint_angles, mean_heading
from .fitting.frames import Track

Array = NDArray[np.float64]
Complex = NDArray[np.complexfloating[Any, Any]]
HARMONICS = 3
LEAST_PERIODS = 1.5
SEARCHED_FRAMES = 600  # a longer film has many periods, and a clear peak in its spectrum
# Weight (of one frame: 1) that holds overtones at 0 where part of a cycle is never seen.
OVERTONES_HELD = 2.5e-3


@dataclass(frozen=True)
class Motion:
    """What the robot did, steady over the film.

    omega_rad_s; amplitude_rad, phase_rad, offset_rad (joints,), phase of the sine at time 0;
    velocity_m_s (2,): mean at time 0, in the plane; turn_rad_s; heading_rad: mean of the links' at
    time 0. Time 0 is the middle of the film.
    """

    omega_rad_s: float
    amplitude_rad: Array
    phase_rad: Array
    offset_rad: Array
    velocity_m_s: Array
    turn_rad_s: float
    heading_rad: float

    @property
    def speed_m_s(self) -> float:
        """Return the mean speed along the path."""
        return float(np.hypot(*self.velocity_m_s))

    @property
    def direction_rad(self) -> float:
        """Return the direction of travel from where the links point in the mean; 0: head first."""
        way = np.arctan2(self.velocity_m_s[1], self.velocity_m_s[0]) - self.heading_rad
        return float((way + np.pi) % (2 * np.pi) - np.pi)

    def numbers(self) -> Array:
        """Return what errors are wanted of.

        Rate, amplitudes, phases beside the tail joint's, offsets, direction, speed, turn.
        """
        apart = self.phase_rad[1:] - self.phase_rad[0]
        apart = (apart + np.pi) % (2 * np.pi) - np.pi
        return np.concatenate(
            [
                [self.omega_rad_s],
                self.amplitude_rad,
                apart,
                self.offset_rad,
                [self.direction_rad, self.speed_m_s, self.turn_rad_s],
            ]
        )


def basis(t_s: Array, omega: float, harmonics: int = HARMONICS) -> Array:
    """Return 1, cos w t, sin w t, cos 2 w t, ..., (frames, 1 + 2 harmonics)."""
    phase = np.outer(t_s, omega * np.arange(1, harmonics + 1))
    waves = np.stack([np.cos(phase), np.sin(phase)], axis=-1).reshape(len(t_s), -1)
    return np.concatenate([np.ones((len(t_s), 1)), waves], axis=1)


def first_rate(t_s: Array, phi: Array, weight: Array) -> float:
    """Return the rate at which one sine explains most of the joints, rad/s; 0 for none.

    A short film is tried at all rates, a long one only near the peak of its spectrum.
    """
    step = float(np.median(np.diff(t_s)))
    unit = 2 * np.pi / (t_s[-1] - t_s[0])
    low, high = 0.6 * unit, 0.9 * np.pi / step
    if len(t_s) > SEARCHED_FRAMES:
        peak = _spectrum_peak(t_s, phi, weight, step)
        low, high = max(low, peak - 1.5 * unit), min(high, peak + 1.5 * unit)
    rates = np.arange(low, high, 0.1 * unit)
    explained = [_explained(t_s, phi, weight, rate) for rate in rates]
    return float(rates[int(np.argmax(explained))]) if len(rates) else 0.0


def _spectrum_peak(t_s: Array, phi: Array, weight: Array, step_s: float) -> float:
    """Return the rate, rad/s, of the joints' largest sum of powers; gaps count for nothing."""
    even = np.arange(t_s[0], t_s[-1], step_s)
    power = np.zeros(len(even) // 2 + 1)
    for i in range(phi.shape[1]):
        there = weight[:, i] > 0
        if there.sum() < 2:
            continue
        seen = np.interp(even, t_s, there.astype(float)) > 0.5
        values = np.interp(even, t_s[there], phi[there, i])
        power += np.abs(np.fft.rfft(np.where(seen, values - values[seen].mean(), 0.0))) ** 2
    return 2 * np.pi * float(power.argmax()) / (len(even) * step_s)


def _explained(t_s: Array, phi: Array, weight: Array, rate: float) -> float:
    columns = basis(t_s, rate, 1)
    total = 0.0
    for i in range(phi.shape[1]):
        root = np.sqrt(weight[:, i])
        a, y = columns * root[:, None], phi[:, i] * root
        total += float(y @ (a @ np.linalg.lstsq(a, y, rcond=None)[0]))
    return total


def fit_joints(
    t_s: Array, phi: Array, weight: Array, omega: float, free_rate: bool = True
) -> tuple[float, Array]:
    """Return rate and coefficients (1 + 2 HARMONICS, joints) of all joints' common rate."""
    for _ in range(12):
        columns = basis(t_s, omega)
        found = _weighted(columns, phi, weight)
        if not free_rate:
            return omega, found
        slope = _slope(t_s, omega) @ found  # by the rate
        rest = phi - columns @ found
        # The rate's own share of the slope: less what the coefficients can take up.
        clean = slope - columns @ _weighted(columns, slope, weight)
        change = float(np.sum(weight * clean * rest) / np.sum(weight * clean * clean))
        omega += change
        if abs(change) < 1e-10 * omega:
            break
    return omega, _weighted(basis(t_s, omega), phi, weight)


def _slope(t_s: Array, omega: float) -> Array:
    """Return the basis' derivative by the rate."""
    out = np.zeros((len(t_s), 1 + 2 * HARMONICS))
    for k in range(1, HARMONICS + 1):
        out[:, 2 * k - 1] = -k * t_s * np.sin(k * omega * t_s)
        out[:, 2 * k] = k * t_s * np.cos(k * omega * t_s)
    return out


def _weighted(columns: Array, values: Array, weight: Array) -> Array:
    """Return least-squares coefficients, each column of values with its own weights."""
    normal = np.einsum("fi,fk,fj->kij", columns, weight, columns, optimize=True)
    size = columns.shape[1]
    hold = np.full(size, 1e-9)
    hold[3 : 1 + 2 * HARMONICS] = OVERTONES_HELD
    normal = normal + np.diag(hold)
    right = np.einsum("fi,fk,fk->ki", columns, weight, values, optimize=True)
    return np.linalg.solve(normal, right[..., None])[..., 0].T


def bend_rate(t_s: Array, bend: Array) -> tuple[float, float]:
    """Return the rate of a bend (frames,) that swings, and its standard deviation, rad/s."""
    one, phi = np.ones((len(t_s), 1)), bend[:, None]
    omega, found = fit_joints(t_s, phi, one, first_rate(t_s, phi, one))
    columns = np.concatenate([basis(t_s, omega), _slope(t_s, omega) @ found], axis=1)
    rest = bend - (columns[:, :-1] @ found)[:, 0]
    variance = rest @ rest / max(1, len(rest) - columns.shape[1]) * correlation_factor(rest)
    return omega, float(np.sqrt(variance * np.linalg.pinv(columns.T @ columns)[-1, -1]))


def fit_path(t_s: Array, z: Complex, weight: Array, omega: float, turn: float) -> Complex:
    """Return z_0, V and the periodic part's coefficients, complex, (2 + 2 HARMONICS,)."""
    a = path_basis(t_s, omega, turn) * np.sqrt(weight)[:, None]
    return np.linalg.lstsq(a, z * np.sqrt(weight), rcond=None)[0]


def path_basis(t_s: Array, omega: float, turn: float) -> Complex:
    """Return the columns of the path's formula: 1, V's, then e^{i (W + k w) t}."""
    turned = np.exp(1j * turn * t_s)
    gone = t_s + 0j if abs(turn) * np.ptp(t_s) < 1e-9 else (turned - 1) / (1j * turn)
    orders = [k for k in range(-HARMONICS, HARMONICS + 1) if k]
    waves = [turned * np.exp(1j * k * omega * t_s) for k in orders]
    return np.stack([np.ones_like(gone), gone, *waves], axis=1)


@dataclass(frozen=True)
class Fitted:
    """The motion with what is left over.

    Residuals of joints (frames, joints), mean heading (frames,) rad, and path (frames,) m; the
    weights of joints and of the path; the joints' coefficients (1 + 2 HARMONICS, joints).
    """

    motion: Motion
    joints_rest_rad: Array
    heading_rest_rad: Array
    path_rest_m: Complex
    weight: Array
    path_weight: Array
    coefficients: Array


def fit_motion(track: Track, weight_joints: Array, weight_path: Array) -> Fitted:
    """Fit rate, sines, path and turn to a track; weights (frames, joints) and (frames,)."""
    t_s, states = track.t_s - track.t_s.mean(), track.states
    phi = joint_angles(states)
    omega = first_rate(t_s, phi, weight_joints)
    return fit_from(t_s, states, phi, weight_joints, weight_path, omega)


def fit_from(
    t_s: Array,
    states: Array,
    phi: Array,
    weight_joints: Array,
    weight_path: Array,
    omega: float,
    free_rate: bool = True,
) -> Fitted:
    """Fit as fit_motion does, from a rate; t_s about its own middle."""
    omega, found = fit_joints(t_s, phi, weight_joints, omega, free_rate)
    rest = phi - basis(t_s, omega) @ found
    heading = mean_heading(states)
    columns = np.concatenate([basis(t_s, omega), t_s[:, None]], axis=1)
    headings = _weighted(columns, heading[:, None], weight_path[:, None])
    turn = float(headings[-1, 0])
    z = states[:, 0] + 1j * states[:, 1]
    path = fit_path(t_s, z, weight_path, omega, turn)
    motion = Motion(
        omega,
        np.hypot(found[1], found[2]),
        np.arctan2(found[1], found[2]),
        found[0],
        np.array([path[1].real, path[1].imag]),
        turn,
        float(headings[0, 0]),
    )
    return Fitted(
        motion,
        rest,
        heading - (columns @ headings)[:, 0],
        z - path_basis(t_s, omega, turn) @ path,
        weight_joints,
        weight_path,
        found,
    )


def joint_slope(t_s: Array, fitted: Fitted, joint: int) -> Array:
    """Return how a joint's fitted angle changes with the rate, (frames,)."""
    return _slope(t_s, fitted.motion.omega_rad_s) @ fitted.coefficients[:, joint]


def correlation_factor(rest: Array) -> float:
    """Return by how much the variance of a mean of such residuals exceeds that of independent ones.

    1 + 2 sum of autocorrelations, summed in pairs while these are above 0.
    """
    r = rest - rest.mean()
    n = len(r)
    power = np.abs(np.fft.rfft(r, 2 * n)) ** 2
    rho = np.fft.irfft(power)[:n]
    if rho[0] <= 0:
        return 1.0
    rho = rho / rho[0]
    total, k = 0.0, 1
    while k + 1 < n // 2 and rho[k] + rho[k + 1] > 0:
        total += rho[k] + rho[k + 1]
        k += 2
    return 1.0 + 2 * max(total, rho[1] if n > 2 and rho[1] > 0 else 0.0)
