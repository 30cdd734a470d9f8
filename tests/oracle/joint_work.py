"""The positive work of joints, the slow obvious way: powers between events, integrated by roots.

The motion is that of contact_modes.py. On each of its smooth pieces every joint's power is fitted
by a Chebyshev series, and its positive part is integrated between the series' own zeros.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.polynomial import Chebyshev

from .contact_modes import Mode, World, pieces
from .params import Array, Gait

_POINTS = 15


@dataclass(frozen=True)
class Forces:
    """Hold what acts on the links at one time."""

    wheels: Array  # (2n,) along and across each link, N
    pins: Array  # (2 (n-1),) x and y of F_i on link i from the next, N
    torques: Array  # (n-1,) T_i on link i from the next, N m


@dataclass
class GaitWorld(World):
    """Hold pinned links whose joints follow a gait exactly."""

    gait: Gait

    def closing(self, t: float, q: Array, v: Array) -> tuple[Array, Array, Array, Array]:
        """Return the constraints of the pins and of the gait, as World.closing does."""
        phi, rate, second = self.gait.angles(t, self.p.links - 1)
        gap, rows, opening, bend = super().closing(t, q, v)
        return (
            np.concatenate([gap, self.turns @ q - phi]),
            np.vstack([rows, self.turns]),
            np.concatenate([opening, rate]),
            np.concatenate([bend, -second]),
        )

    def forces(self, t: float, y: Array, mode: Mode) -> Forces:
        """Return what wheels and joints do: the constraints' multipliers."""
        q, v = np.split(y, 2)
        accel, held, touch, _ = self.solve(t, y, mode)
        rest = self.mass @ accel - self.pushes(t, q, v, mode, touch)
        rest -= touch[mode.basis].T @ held
        joints = np.linalg.lstsq(self.closing(t, q, v)[1].T, rest, rcond=None)[0]
        wheels = -self.drag(touch @ v, mode)
        wheels[mode.basis] = held
        pins = 2 * (self.p.links - 1)
        return Forces(wheels, -joints[:pins], -joints[pins:])

    def joint_powers(self, t: float, y: Array, mode: Mode) -> Array:
        """Return what each joint gives, W: the multiplier of its angle times its rate."""
        return -self.forces(t, y, mode).torques * (self.turns @ np.split(y, 2)[1])


def joint_powers(world: World, t: float, y: Array, mode: Mode) -> Array:
    """Return what each joint gives to the links, W: behind rotor and gear, if it has these."""
    if isinstance(world, GaitWorld):
        return world.joint_powers(t, y, mode)
    phi, rate = (world.turns @ part for part in np.split(y, 2))
    torque = -world.drive.torques(t, phi, rate, mode.region)
    if world.drive.rotor:
        torque -= world.drive.rotor * world.turns @ world.solve(t, y, mode)[0]
    if world.drive.gear_dry:
        torque -= world.drive.gear_dry * mode.slide[2 * world.p.links :]
    return torque * rate


def positive_work(
    world: World, y: Array, end_s: float, rtol: float = 1e-12, longest_s: float = 0.01
) -> float:
    """Return the integral of sum P_i^+ from t = 0 to the end, J."""
    x = np.cos(np.pi * (np.arange(_POINTS) + 0.5) / _POINTS)
    work, before = 0.0, 0.0
    for until, track, mode in pieces(world, y, end_s, rtol=rtol, longest_s=longest_s):
        half = (until - before) / 2
        if half > 0:
            at = before + half * (1 + x)
            powers = np.array([joint_powers(world, t, track(t), mode) for t in at])
            work += half * sum(map(_positive, (Chebyshev.fit(x, p, _POINTS - 1) for p in powers.T)))
        before = until
    return work


def _positive(power: Chebyshev) -> float:
    roots = power.roots()
    inside = np.sort(roots[(abs(roots.imag) < 1e-12) & (abs(roots.real) < 1)].real)
    up = power.integ()
    return sum(max(up(b) - up(a), 0.0) for a, b in pairwise([-1.0, *inside, 1.0]))
