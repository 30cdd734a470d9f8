"""Periodic state, speed and powers on set-valued ground, from the event-driven motion."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.optimize import brentq

from . import bingham
from . import body_frame as bf
from .bingham import Piece, System
from .params import Array, Gait, Params

NODES, WEIGHTS = np.polynomial.legendre.leggauss(6)


@dataclass(frozen=True)
class PeriodicBingham:
    """Hold a periodic state on set-valued ground; displacement over one period from t = 0."""

    u0: Array  # (3,) velocity and spin of link 1 in its own frame at t = 0
    speed_m_s: float  # of the centre of mass
    turn_rad_per_cycle: float
    power_w: float
    abs_power_w: float
    positive_power_w: float
    dissipation_w: float
    events: int  # mode changes in a period
    stuck_fraction: float  # of contact-time
    residual: float  # |u(T) - u(0)|, largest component


def fixed_point(step: Callable[[Array], Array], u: Array, tolerance: float) -> tuple[Array, float]:
    """Return u = step(u) and its residual, by Anderson acceleration over the last four iterates.

    A plain iteration converges as the slowest Floquet multiplier, and a Newton step is spoilt by
    the kinks that contacts at rest give the period map.
    """
    points, images = [], []
    for _ in range(60):
        image = step(u)
        points, images = [*points[-3:], u], [*images[-3:], image]
        gaps = np.array(images) - np.array(points)
        residual = float(np.abs(gaps[-1]).max())
        if residual < tolerance:
            return image, residual
        weights = np.linalg.lstsq((gaps[1:] - gaps[:-1]).T, gaps[-1], rcond=1e-10)[0]
        u = image - weights @ (np.diff(images, axis=0).reshape(-1, 3))
    raise RuntimeError(f"no periodic state: the last cycle still changed by {residual}")


def cycle(system: System, u0: Array, rtol: float) -> list[Piece]:
    """Return the smooth pieces of one period from body-frame velocities u0."""
    start = np.concatenate([u0, np.zeros(3)])
    return list(bingham.run(system, start, 0.0, system.gait.period_s, rtol=rtol))


def steady(p: Params, gait: Gait, rtol: float = 1e-10, u0: Array | None = None) -> PeriodicBingham:
    """Return the periodic state of a gait on set-valued ground."""
    system = System(p, gait)
    scale = gait.omega_rad_s

    def step(u: Array) -> Array:
        last = cycle(system, u, rtol)[-1]
        return last.at(last.end_s)[:3]

    start = np.zeros(3) if u0 is None else np.asarray(u0, float)
    for _ in range(2 if u0 is None else 0):
        start = step(start)
    u, residual = fixed_point(step, start, 10 * rtol * scale)
    pieces = cycle(system, u, rtol)
    end = pieces[-1].at(gait.period_s)
    net, total, loss = np.sum([piece_work(system, piece) for piece in pieces], 0) / gait.period_s
    offset = bf.shape_at(p, gait, 0.0).place[0].mean(0)
    turn = np.array([[np.cos(end[3]), -np.sin(end[3])], [np.sin(end[3]), np.cos(end[3])]])
    changes = sum((a.mode != b.mode).any() for a, b in pairwise(pieces))
    stuck = sum((piece.mode == 0).mean() * (piece.end_s - piece.start_s) for piece in pieces)
    return PeriodicBingham(
        u0=u,
        speed_m_s=float(np.hypot(*(end[4:6] + turn @ offset - offset))) / gait.period_s,
        turn_rad_per_cycle=float(end[3]),
        power_w=float(net),
        abs_power_w=float(total),
        positive_power_w=float(net + total) / 2,
        dissipation_w=float(loss),
        events=int(changes),
        stuck_fraction=float(stuck) / gait.period_s,
        residual=residual,
    )


def powers(system: System, piece: Piece, t_s: float) -> tuple[Array, float]:
    """Return joint powers -T_i phi_i' (n-1,) and friction's loss at a time of a piece, W."""
    y = piece.at(t_s)
    rate, force, touch, shape = system.forces(t_s, y[:3], piece.mode)
    ground = bf.contact_forces(shape, force.reshape(-1, 2))
    torque = bf.joint_torques(system.p, shape, y[:3], rate, ground)
    return -torque * shape.phi_dot, float(-force @ touch.slip)


def piece_work(system: System, piece: Piece) -> Array:
    """Return (sum of P, sum of |P|, loss) integrated over a piece, J; |P| is split at its roots."""
    middle, half = (piece.start_s + piece.end_s) / 2, (piece.end_s - piece.start_s) / 2
    values = [powers(system, piece, middle + half * node) for node in NODES]
    power, loss = np.array([v[0] for v in values]), np.array([v[1] for v in values])
    work = half * WEIGHTS @ power
    edges = [powers(system, piece, t)[0] for t in (piece.start_s, piece.end_s)]
    signs = np.sign(np.vstack([edges[0], power, edges[1]]))
    total = np.abs(work)
    for joint in np.flatnonzero((signs != signs[0]).any(0)):
        total[joint] = split_work(system, piece, joint)
    return np.array([work.sum(), total.sum(), half * WEIGHTS @ loss])


def split_work(system: System, piece: Piece, joint: int) -> float:
    """Return the integral of |P_joint| over a piece, J, between the roots of P_joint."""

    def power(t: float) -> float:
        return powers(system, piece, t)[0][joint]

    grid = np.linspace(piece.start_s, piece.end_s, 9)
    value = [power(t) for t in grid]
    cuts = [piece.start_s]
    for k in range(8):
        if value[k] * value[k + 1] < 0:
            cuts.append(brentq(power, grid[k], grid[k + 1], xtol=1e-15, rtol=1e-13))
    cuts.append(piece.end_s)
    total = 0.0
    for a, b in pairwise(cuts):
        inside = [power((a + b) / 2 + (b - a) / 2 * node) for node in NODES]
        total += abs((b - a) / 2 * WEIGHTS @ inside)
    return total
