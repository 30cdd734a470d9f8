"""Set-valued friction by another way: implicit Euler, each step a small convex problem.

The velocities at the end of a step minimise a strictly convex function of three unknowns, inertia
and viscous friction its quadratic part and sum F_0 |v_k| its kinks. No events, no smoothing; the
error is of first order in the step, so two resolutions are extrapolated. It checks bingham.py.
"""

from __future__ import annotations

import numpy as np

from . import body_frame as bf
from .bingham import System, contacts_at
from .bingham_periodic import fixed_point
from .params import Array, Gait, Params


class Kinked:
    """The function u.A u / 2 - b.u + sum F_k |rows_k u + drive_k| of u (3,), strictly convex."""

    def __init__(self, matrix: Array, load: Array, rows: Array, drive: Array, weight: Array):
        self.matrix, self.load = matrix, load
        self.rows, self.drive, self.weight = rows, drive, weight

    def on_face(self, mode: Array) -> tuple[Array, Array]:
        """Return the minimiser with signs held and zero modes exactly at rest, and the holds."""
        stuck = (mode == 0) & (self.weight > 0)
        inverse = np.linalg.inv(self.matrix)
        free = inverse @ (self.load - self.rows.T @ (self.weight * mode))
        held = self.rows[stuck]
        response = held @ inverse @ held.T
        hold = np.linalg.lstsq(response, -(held @ free + self.drive[stuck]), rcond=None)[0]
        force = np.zeros(len(mode))
        force[stuck] = hold
        return free + inverse @ held.T @ hold, force

    def minimise(self, mode: Array) -> tuple[Array, Array]:
        """Return the minimiser and its mode, starting from a guess of the mode."""
        u = self.on_face(mode)[0]
        speed = self.rows @ u + self.drive
        mode = np.where((mode == 0) & (np.abs(speed) < 1e-14), 0, np.sign(speed)).astype(int)
        for _ in range(200):
            target, force = self.on_face(mode)
            if np.abs(target - u).max() > 1e-13 * (np.abs(u).max() + 1e-3):
                u, mode = self.descend(u, target - u, mode)
                continue
            excess = np.where(mode == 0, np.abs(force) - self.weight, -np.inf)
            worst = int(np.argmax(excess))
            if excess[worst] <= 1e-12 * self.weight.max():
                return target, mode
            mode = mode.copy()
            mode[worst] = -int(np.sign(force[worst]))
        raise RuntimeError("the convex step did not finish")

    def descend(self, u: Array, direction: Array, mode: Array) -> tuple[Array, Array]:
        """Return the lowest point on u + s direction, s >= 0, and its mode; kinks may stop it."""
        speed, change = self.rows @ u + self.drive, self.rows @ direction
        bend = direction @ self.matrix @ direction
        slope = -bend  # u + direction is the lowest point as long as no kink is met
        meets = (mode != 0) & (mode * change < 0) & (self.weight > 0)
        place = np.where(meets, -speed / np.where(meets, change, 1.0), np.inf)
        mode = mode.copy()
        for k in np.argsort(place):
            if slope + bend * place[k] >= 0:
                break
            step = 2 * self.weight[k] * abs(change[k])
            if slope + bend * place[k] + step >= 0:
                mode[k] = 0
                return u + place[k] * direction, mode
            slope, mode[k] = slope + step, -mode[k]
        return u - slope / bend * direction, mode


def step(system: System, t_s: float, h: float, u: Array, mode: Array) -> tuple[Array, Array]:
    """Return u and the contact modes at t + h after one implicit step from u at t."""
    p, shape = system.p, bf.shape_at(system.p, system.gait, t_s + h)
    touch = contacts_at(shape, u)
    drive = touch.slip - touch.rows @ u
    mass = bf.mass_matrix(p, shape) / h
    load = bf.resultant(shape, -p.mass_kg * bf.known_accelerations(shape, u))
    load[2] -= p.inertia * shape.psi[2].sum()
    drag = touch.rows.T * system.viscous
    matrix = mass + drag @ touch.rows
    load = mass @ u + load - drag @ drive
    return Kinked(matrix, load, touch.rows, drive, system.threshold).minimise(mode)


def travel(place: Array, u: Array, h: float) -> Array:
    """Return link 1's (heading, x, y) a step later, at constant body-frame velocities."""
    heading = place[0] + h / 2 * u[2]
    cos, sin = np.cos(heading), np.sin(heading)
    return place + h * np.array([u[2], cos * u[0] - sin * u[1], sin * u[0] + cos * u[1]])


def march(system: System, u: Array, steps: int, parts: int = 64) -> tuple[Array, Array]:
    """Return u at the end of a period and link 1's (heading, x, y) there, after equal steps.

    A step in which a contact changes its mode is taken again in parts: where in a step an event
    falls is chance, and would add a noise of first order that no extrapolation removes.
    """
    h, place = system.gait.period_s / steps, np.zeros(3)
    mode = np.sign(contacts_at(bf.shape_at(system.p, system.gait, 0.0), u).slip).astype(int)
    for k in range(steps):
        after, after_mode = step(system, k * h, h, u, mode)
        if (after_mode == mode).all():
            u = after
            place = travel(place, u, h)
            continue
        for part in range(parts):
            u, mode = step(system, k * h + part * h / parts, h / parts, u, mode)
            place = travel(place, u, h / parts)
    return u, place


def speed(p: Params, gait: Gait, u0: Array, steps: int) -> float:
    """Return the centre of mass's speed in the periodic state of the stepped motion."""
    system = System(p, gait)
    u, _ = fixed_point(lambda u: march(system, u, steps)[0], u0, 1e-11 * gait.omega_rad_s)
    heading, x, y = march(system, u, steps)[1]
    offset = bf.shape_at(p, gait, 0.0).place[0].mean(0)
    cos, sin = np.cos(heading), np.sin(heading)
    turned = np.array([cos * offset[0] - sin * offset[1], sin * offset[0] + cos * offset[1]])
    return float(np.hypot(*(np.array([x, y]) + turned - offset))) / gait.period_s


def extrapolated_speed(p: Params, gait: Gait, u0: Array, steps: int) -> tuple[float, float]:
    """Return the speed extrapolated to no step from three resolutions, and what the last added.

    steps, 2 steps and 4 steps a period; the first two powers of the step are removed. Events fall
    anywhere inside a step, which leaves noise of second order.
    """
    coarse, middle, fine = (speed(p, gait, u0, steps * factor) for factor in (1, 2, 4))
    best = (8 * fine - 6 * middle + coarse) / 3
    return best, abs(best - (2 * fine - middle))
