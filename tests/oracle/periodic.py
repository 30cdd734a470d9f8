"""The periodic state by brute force: shooting over a whole period of the body-frame velocities.

Viscous ground only. No mirror symmetry, no collocation: DOP853 at tolerances near rounding, Newton
on the period map with a complex-step Jacobian. The powers' absolute values are integrated between
the roots of each joint's power.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

from . import body_frame as bf
from .params import Array, Gait, Params


@dataclass(frozen=True)
class Periodic:
    """Hold a periodic state; displacements are over one period from t = 0.

    Where the snake turns, the chord of a period depends on the point followed and on the phase it
    starts at: `speed_m_s` follows the centre of mass, `speed_link1_m_s` the tail link, both from
    t = 0. `mean_speed_m_s`, the centre of mass's mean velocity in a frame that turns evenly with
    the cycle, does not depend on the phase. Without a turn all three are one.
    """

    u0: Array  # (3,) velocity and spin of link 1 in its own frame at t = 0
    speed_m_s: float
    speed_link1_m_s: float
    mean_speed_m_s: float
    turn_rad_per_cycle: float
    power_w: float
    abs_power_w: float
    positive_power_w: float
    dissipation_w: float
    multipliers: Array  # (3,) complex, largest magnitude first
    fourier_tail: float  # size of the joint powers' unresolved harmonics, relative


def rate(p: Params, gait: Gait, t_s: float, y: Array) -> Array:
    """Return y' of y = (u, heading, x, y of link 1 in the frame it started in), (6,)."""
    shape, u = bf.shape_at(p, gait, t_s), y[:3]
    cos, sin = np.cos(y[3]), np.sin(y[3])
    travel = [u[2], cos * u[0] - sin * u[1], sin * u[0] + cos * u[1]]
    return np.concatenate([bf.u_dot(p, shape, u, bf.viscous(p, shape, u)), travel])


def march(
    p: Params, gait: Gait, u0: Array, samples: int, *, rtol: float = 1e-13, steps: int = 64
) -> Array:
    """Return y at t = 0, T/samples .. T, (samples + 1, 6), by DOP853 of at least `steps` steps."""
    period = gait.period_s
    times = np.linspace(0.0, period, samples + 1)
    start = np.concatenate([u0, np.zeros(3)])
    result = solve_ivp(
        lambda t, y: rate(p, gait, t, y),
        (0.0, period),
        start,
        "DOP853",
        times,
        rtol=rtol,
        atol=rtol * 1e-2,
        max_step=period / steps,
    )
    if not result.success:
        raise RuntimeError(result.message)
    return result.y.T


def period_map(p: Params, gait: Gait, u0: Array) -> tuple[Array, Array]:
    """Return u(T) and its Jacobian (3, 3) with respect to u(0), by complex steps."""
    step, columns = 1e-30, []
    for axis in np.eye(3):
        end = march(p, gait, u0 + 1j * step * axis, 1)[-1, :3]
        columns.append(end.imag / step)
    return end.real, np.stack(columns, -1)


def settle(p: Params, gait: Gait, u0: Array | None = None) -> tuple[Array, Array]:
    """Return u(0) of the periodic state and the period map's Jacobian there."""
    u = np.zeros(3) if u0 is None else np.asarray(u0, float)
    for _ in range(2):
        u = march(p, gait, u, 1, rtol=1e-8)[-1, :3]
    for _ in range(20):
        end, jacobian = period_map(p, gait, u)
        change = np.linalg.solve(np.eye(3) - jacobian, end - u)
        u = u + change
        if np.abs(change).max() <= 1e-13 * np.abs(u).max():
            return u, jacobian
    if np.abs(change).max() <= 1e-11 * np.abs(u).max():
        return u, jacobian  # rounding of a stiff period map
    raise RuntimeError(f"no periodic state: last change {change}")


def steady(p: Params, gait: Gait, samples: int = 256) -> Periodic:
    """Return the periodic state of a gait on viscous ground."""
    u0, jacobian = settle(p, gait)
    track = march(p, gait, u0, samples)
    end = track[-1]
    power, loss = powers(p, gait, track[:-1])
    net, total, tail = split_means(power)
    offset = bf.shape_at(p, gait, 0.0).place[0].mean(0)
    tail_link = end[4:6]
    centre = tail_link + rotated(offset, end[3]) - offset
    multipliers = np.linalg.eigvals(jacobian)
    return Periodic(
        u0=u0,
        speed_m_s=float(np.hypot(*centre)) / gait.period_s,
        speed_link1_m_s=float(np.hypot(*tail_link)) / gait.period_s,
        mean_speed_m_s=mean_speed(p, gait, track),
        turn_rad_per_cycle=float(end[3]),
        power_w=net,
        abs_power_w=total,
        positive_power_w=(net + total) / 2,
        dissipation_w=float(loss.mean()),
        multipliers=multipliers[np.argsort(-np.abs(multipliers), kind="stable")],
        fourier_tail=tail,
    )


def mean_speed(p: Params, gait: Gait, track: Array) -> float:
    """Return |mean of the centre of mass's velocity| in the frame that turns evenly, m/s."""
    total, count = np.zeros(2), len(track) - 1
    for k, y in enumerate(track[:-1]):
        shape = bf.shape_at(p, gait, gait.period_s * k / count)
        velocity = bf.link_velocities(shape, y[:3]).mean(0)
        total += rotated(velocity, y[3] - track[-1, 3] * k / count)
    return float(np.hypot(*total)) / count


def rotated(vector: Array, angle: float) -> Array:
    """Return a plane vector turned by an angle."""
    cos, sin = np.cos(angle), np.sin(angle)
    return np.array([cos * vector[0] - sin * vector[1], sin * vector[0] + cos * vector[1]])


def powers(p: Params, gait: Gait, track: Array) -> tuple[Array, Array]:
    """Return joint powers -T_i phi_i' (samples, n-1) and friction's loss (samples,), W."""
    joint, loss = [], []
    for k, y in enumerate(track):
        shape = bf.shape_at(p, gait, gait.period_s * k / len(track))
        ground = bf.viscous(p, shape, y[:3])
        torque = bf.joint_torques(p, shape, y[:3], bf.u_dot(p, shape, y[:3], ground), ground)
        joint.append(-torque * shape.phi_dot)
        loss.append(np.sum(bf.slip(shape, y[:3]) ** 2 * np.array([p.ct, p.cn])))
    return np.array(joint), np.array(loss)


def split_means(samples: Array) -> tuple[float, float, float]:
    """Return the sum over columns of the means of P and of |P|, and the largest Fourier tail.

    P (samples, columns) is one period, equally spaced, of smooth functions. Each is taken as its
    trigonometric interpolant, whose roots are found and whose antiderivative is exact.
    """
    net = total = tail = 0.0
    for column in samples.T:
        series = Fourier(column)
        roots = series.roots()
        net += series.mean
        total += series.mean_abs(roots)
        tail = max(tail, series.tail)
    return net, total, tail


class Fourier:
    """A real periodic function on [0, 1) from equally spaced samples."""

    def __init__(self, samples: Array) -> None:
        spectrum = np.fft.rfft(samples) / len(samples)
        size = np.abs(spectrum).max() or 1.0
        self.tail = float(np.abs(spectrum[-len(spectrum) // 8 :]).max() / size)
        self.mean = float(spectrum[0].real)
        self.order = np.arange(1, len(spectrum) - 1)  # the Nyquist term carries no phase
        self.coefficients = 2 * spectrum[1:-1]

    def __call__(self, place: Array) -> Array:
        """Return the function at places in periods, (m,)."""
        waves = np.exp(2j * np.pi * np.outer(place, self.order))
        return self.mean + (waves @ self.coefficients).real

    def integral(self, place: Array) -> Array:
        """Return an antiderivative at places in periods, (m,)."""
        waves = np.exp(2j * np.pi * np.outer(place, self.order))
        return self.mean * place + (waves @ (self.coefficients / (2j * np.pi * self.order))).real

    def roots(self, cells: int = 4096) -> Array:
        """Return the places where the sign changes, seen on a grid and bisected to rounding."""
        grid = np.linspace(0.0, 1.0, cells + 1)
        value = self(grid)
        value[-1] = value[0]
        above = value > 0  # a sample may be zero itself: half-open signs miss no change
        seen = np.flatnonzero(above[:-1] != above[1:])
        low, high, sign = grid[seen], grid[seen + 1], np.where(above[seen], 1.0, -1.0)
        for _ in range(45):
            middle = (low + high) / 2
            before = self(middle) * sign > 0
            low, high = np.where(before, middle, low), np.where(before, high, middle)
        return (low + high) / 2

    def mean_abs(self, roots: Array) -> float:
        """Return the mean of |f| given the roots of f."""
        if len(roots) == 0:
            return abs(self.mean)
        ends = np.append(roots, roots[0] + 1.0)
        return float(np.abs(np.diff(self.integral(ends))).sum())
