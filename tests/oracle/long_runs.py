"""Runs of thousands of cycles on viscous ground: one cycle's motion in long doubles, composed.

The exact model by its momenta: P and L about link 1 change by the friction alone, and the three
rates of link 1 follow from them, since momenta are linear in rates. No acceleration occurs. A
settled cycle moves the body by one and the same motion g of the plane; after N cycles it is at
g^N, to rounding.
"""

from __future__ import annotations

import numpy as np

from .params import Array, Gait, Params
from .springs_collocation import Long, radau_nodes

STAGES, STEPS_A_CYCLE = 10, 30


def _shape(p: Params, gait: Gait, t: Long) -> tuple[Array, Array]:
    """Return link angles less theta_1 and their rates, (n,) each."""
    joints = np.arange(p.links - 1, dtype=Long)
    phase = Long(gait.omega_rad_s) * t + joints * Long(gait.beta_rad)
    swing = Long(gait.alpha_rad)
    turn = np.concatenate([[Long(0)], np.cumsum(swing * np.sin(phase) + gait.offset_rad)])
    rate = np.concatenate([[Long(0)], np.cumsum(swing * gait.omega_rad_s * np.cos(phase))])
    return turn, rate


def _chain(p: Params, theta: Array, omega: Array) -> tuple[Array, Array]:
    """Return link centres from that of link 1 and their velocities, complex (n,)."""
    arm = Long(p.half_length_m) * (np.cos(theta) + 1j * np.sin(theta))
    swing = 1j * omega * arm

    def centres(ends: Array) -> Array:
        return np.concatenate([[0], np.cumsum(ends[1:] + ends[:-1])])

    return centres(arm), centres(swing)


def rate(p: Params, gait: Gait, t: Long, y: Array) -> Array:
    """Return y' of y = (x_1, y_1, theta_1, P_x, P_y, L about link 1's centre)."""
    turn, turn_rate = _shape(p, gait, t)
    theta = y[2] + turn
    mass, inertia = Long(p.mass_kg), Long(p.inertia)

    def momenta(v: complex, omega: Long) -> tuple[Array, Array]:
        place, speed = _chain(p, theta, omega + turn_rate)
        speed = speed + v
        linear = mass * speed.sum()
        spin = (mass * (place.conj() * speed).imag + inertia * (omega + turn_rate)).sum()
        return np.array([linear.real, linear.imag, spin]), speed

    none, _ = momenta(0, Long(0))
    columns = [momenta(v, w)[0] - none for v, w in ((1, 0), (1j, 0), (0, Long(1)))]
    a, b = np.array(columns).T, y[3:] - none
    inverse = np.linalg.inv(a.astype(float)).astype(Long)
    own = inverse @ b
    for _ in range(3):
        own = own + inverse @ (b - a @ own)
    _, speed = momenta(own[0] + 1j * own[1], own[2])
    along = np.cos(theta) + 1j * np.sin(theta)
    local = speed * along.conj()
    force = -(Long(p.ct) * local.real + 1j * Long(p.cn) * local.imag) * along
    place, _ = _chain(p, theta, theta)
    total, linear = force.sum(), y[3] + 1j * y[4]
    moment = (place.conj() * force).imag.sum()
    moment -= ((own[0] - 1j * own[1]) * linear).imag  # link 1, the reference point, moves
    return np.array([*own, total.real, total.imag, moment])


def cycle(p: Params, gait: Gait, y: Array) -> Array:
    """Return y after one cycle from the phase 0, by collocation with fixed point iteration."""
    node, A = radau_nodes(STAGES)
    h = 8 * np.arctan(Long(1)) / Long(gait.omega_rad_s) / STEPS_A_CYCLE
    slope = np.tile(rate(p, gait, Long(0), y), (STAGES, 1))
    for k in range(STEPS_A_CYCLE):
        for _ in range(60):
            stages = y + h * (A @ slope)
            fresh = np.array(
                [rate(p, gait, h * (k + x), s) for x, s in zip(node, stages, strict=True)]
            )
            move = abs(fresh - slope).max()
            slope = fresh
            if move < 1e-17:
                break
        y = y + h * (A @ slope)[-1]
    return y


def after(p: Params, gait: Gait, q: Array, v: Array, cycles: int) -> tuple[complex, float]:
    """Return place, m, and angle, rad, of link 1 after many cycles from q, v (x, y, theta)."""
    turn, turn_rate = _shape(p, gait, Long(0))
    place, speed = _chain(p, q[2] + turn, v[2] + turn_rate)
    speed = speed + v[0] + 1j * v[1]
    linear = p.mass_kg * speed.sum()
    spin = (p.mass_kg * (place.conj() * speed).imag + p.inertia * (v[2] + turn_rate)).sum()
    y = np.array([*q, linear.real, linear.imag, spin], dtype=Long)
    gone, before = 0, y
    while gone < cycles:  # until the body's own momenta repeat
        before, y, gone = y, cycle(p, gait, y), gone + 1
        own = [(s[3] + 1j * s[4]) * np.exp(-1j * s[2]) for s in (before, y)]
        if abs(own[1] - own[0]) + abs(y[5] - before[5]) < 1e-16:
            break
    left = Long(cycles - gone)
    step = (y[0] - before[0] + 1j * (y[1] - before[1])) * np.exp(-1j * y[2])  # as seen at its end
    bend = y[2] - before[2]
    # sum of step * exp(i (theta + j bend)), j = 1..left
    factor = left if bend == 0 else np.expm1(1j * left * bend) / np.expm1(1j * bend)
    way = step * np.exp(1j * (y[2] + bend)) * factor
    return complex(y[0] + 1j * y[1] + way), float(y[2] + left * bend)
