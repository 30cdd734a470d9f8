"""Periodic states on any ground by extrapolated implicit Euler whose steps keep to one mode.

A third way beside bingham.py (event functions, explicit) and bingham_stepping.py (order one), and
written from the balance of momenta about the centre of mass, not link 1's. Unknown is (Vx, Vy, L)
in the axes of link 1. Within a mode (every wheel slides one way or sticks) implicit Euler steps are
linear, and six of them, of 1, 2 .. 6 parts, extrapolate to order six however stiff the friction is.
A step at whose points the mode does not hold is cut to a third, down to 1e-11 of a period; then one
such step with the law itself, solved by descent on the wheels' forces, finds the next mode.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from .params import Array, Gait, Params

SHORTEST = 1e-11  # of a period
LONGEST = 1 / 300
NODES, WEIGHTS = np.polynomial.legendre.leggauss(5)


@dataclass(frozen=True)
class Pose:
    """Hold a shape seen from its centre of mass in the axes of link 1; rates are of time.

    axis (2n, 2): directions of the wheels, along and across each link, and axis_rate; arm (3, n,
    2): the links' places and their two rates; turn (3, n): angles and rates. inertia: J and J';
    own: K and K', the momentum about the centre of mass that the joints' motion itself has.
    """

    axis: Array
    axis_rate: Array
    arm: Array
    turn: Array
    inertia: tuple[float, float]
    own: tuple[float, float]

    @property
    def rows(self) -> Array:
        """Return what the wheels' speeds have of (Vx, Vy, w), (2n, 3)."""
        return np.column_stack([self.axis, cross(np.repeat(self.arm[0], 2, 0), self.axis)])

    @property
    def drive(self) -> Array:
        """Return the wheels' speeds when the centre rests and link 1 does not turn, (2n,)."""
        return np.sum(np.repeat(self.arm[1], 2, 0) * self.axis, -1)

    def bias(self, u: Array) -> Array:
        """Return the rates of the wheels' speeds while u is constant, (2n,)."""
        arm, rate, second = (np.repeat(part, 2, 0) for part in self.arm)
        spin = cross(rate, self.axis) + cross(arm, self.axis_rate)
        shape = np.sum(second * self.axis + rate * self.axis_rate, -1)
        return self.axis_rate @ u[:2] + spin * u[2] + shape


def cross(a: Array, b: Array) -> Array:
    """Return the cross products of plane vectors."""
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


class Snake:
    """A snake under a gait on any ground."""

    def __init__(self, p: Params, gait: Gait, spin: float = 0.0) -> None:
        self.p, self.gait, self.spin = p, gait, spin
        self.mass = p.links * p.mass_kg
        self.viscous = np.tile([p.ct, p.cn], p.links)
        self.dry = np.tile([p.ft0, p.fn0], p.links)
        back = p.backwards
        self.viscous_back = np.tile([back[0], p.cn], p.links)
        self.dry_back = np.tile([back[1], p.fn0], p.links)
        self.grips = self.dry + self.dry_back > 0
        self.modal = self.grips | (self.viscous != self.viscous_back)
        self.speed = gait.omega_rad_s * p.half_length_m * max(gait.alpha_rad, 1e-6)

    def pose(self, t_s: float) -> Pose:
        """Return the shape at a time."""
        p, g = self.p, self.gait
        wave = g.omega_rad_s * t_s + np.arange(p.links - 1) * g.beta_rad
        bends = [g.offset_rad + g.alpha_rad * np.sin(wave)]
        bends += [g.alpha_rad * g.omega_rad_s * np.cos(wave)]
        bends += [-g.alpha_rad * g.omega_rad_s**2 * np.sin(wave)]
        turn = np.array([np.concatenate([[0.0], np.cumsum(b)]) for b in bends])
        along = np.stack([np.cos(turn[0]), np.sin(turn[0])], -1)
        left = np.stack([-along[:, 1], along[:, 0]], -1)
        rate = left * turn[1][:, None]
        second = left * turn[2][:, None] - along * (turn[1] ** 2)[:, None]
        arm = []
        for part in (along, rate, second):
            place = np.zeros_like(part)
            place[1:] = np.cumsum(part[:-1] + part[1:], 0) * p.half_length_m
            arm.append(place - place.mean(0))
        axis = np.stack([along, left], 1).reshape(-1, 2)
        axis_rate = np.stack([rate, -along * turn[1][:, None]], 1).reshape(-1, 2)
        m, i = p.mass_kg, p.inertia
        inertia = p.links * i + m * np.sum(arm[0] ** 2), 2 * m * np.sum(arm[0] * arm[1])
        own = [m * np.sum(cross(arm[0], arm[k])) + i * np.sum(turn[k]) for k in (1, 2)]
        return Pose(axis, axis_rate, np.array(arm), turn, inertia, (own[0], own[1]))

    def velocity(self, pose: Pose, y: Array) -> Array:
        """Return u = (Vx, Vy, w)."""
        return np.array([y[0], y[1], (y[2] - pose.own[0]) / pose.inertia[0]])

    def law(self, mode: Array) -> tuple[Array, Array]:
        """Return slope and value at rest of the friction on wheels that slide as a mode says."""
        slope = np.where(mode < 0, self.viscous_back, self.viscous)
        return slope, np.where(mode < 0, -self.dry_back, self.dry)

    def euler(
        self, y: Array, t_s: float, h: float, mode: Array, before: Pose
    ) -> tuple[Array, Pose]:
        """Return the state after an implicit step in a mode, and its pose."""
        pose = self.pose(t_s + h)
        rows, drive = pose.rows, pose.drive
        slide = mode != 0
        slope, rest = self.law(mode)
        loose, ds = rows[slide], drive[slide]
        matrix = np.diag([self.mass, self.mass, pose.inertia[0]])
        matrix += h * (loose.T * slope[slide]) @ loose
        load = self.carried(y, h, before, pose) - h * loose.T @ (slope[slide] * ds + rest[slide])
        inverse = np.linalg.inv(matrix)
        u = inverse @ load
        if not slide.all():
            held = rows[~slide]
            response = held @ inverse @ held.T
            u = u + inverse @ held.T @ solve(response, -drive[~slide] - held @ u)
        slip = loose @ u + ds
        return self.after(y, t_s + h, h, u, pose, float(slip @ (slope[slide] * slip + rest[slide])))

    def carried(self, y: Array, h: float, before: Pose, pose: Pose) -> Array:
        """Return what momenta a step starts with, in the axes at its end."""
        angle = h * self.velocity(before, y)[2]
        c, s = math.cos(angle), math.sin(angle)
        turned = [c * y[0] + s * y[1], c * y[1] - s * y[0]]
        return np.array([self.mass * turned[0], self.mass * turned[1], y[2] - pose.own[0]])

    def after(
        self, y: Array, t_s: float, h: float, u: Array, pose: Pose, loss: float
    ) -> tuple[Array, Pose]:
        """Return the state at the end of a step at which u and the loss, W, are known."""
        theta = y[3] + h * u[2]
        c, s = math.cos(theta - self.spin * t_s), math.sin(theta - self.spin * t_s)
        way = np.array([c * u[0] - s * u[1], s * u[0] + c * u[1]])
        momentum = pose.inertia[0] * u[2] + pose.own[0]
        return np.array([u[0], u[1], momentum, theta, *(y[4:6] + h * way), y[6] + h * loss]), pose

    def kick(self, y: Array, t_s: float, h: float, before: Pose) -> Array:
        """Return the mode after a step of the law itself, by descent on one force a time."""
        pose = self.pose(t_s + h)
        rows, drive = pose.rows, pose.drive
        mass = np.array([self.mass, self.mass, pose.inertia[0]])
        u = self.carried(y, h, before, pose) / mass
        give = h * np.sum(rows**2 / mass, -1)
        force, slip = np.zeros(len(rows)), np.zeros(len(rows))
        for _ in range(20000):
            most = 0.0
            for k in range(len(rows)):
                free = float(rows[k] @ u + drive[k] - give[k] * force[k])
                if free > give[k] * self.dry[k]:
                    slip[k] = (free - give[k] * self.dry[k]) / (1 + give[k] * self.viscous[k])
                elif free < -give[k] * self.dry_back[k]:
                    slip[k] = free + give[k] * self.dry_back[k]
                    slip[k] /= 1 + give[k] * self.viscous_back[k]
                else:
                    slip[k] = 0.0
                change = (slip[k] - free) / give[k] - force[k]
                force[k] += change
                u = u + h * rows[k] / mass * change
                most = max(most, abs(change) * give[k])
            if most < 1e-15 * self.speed:
                break
        return np.where(self.grips | (slip != 0), np.sign(slip), 1).astype(int)

    def forces(self, y: Array, t_s: float, mode: Array) -> tuple[Array, Array, Array, Pose]:
        """Return the wheels' forces (2n,), u', u and the pose at an instant of a mode."""
        pose = self.pose(t_s)
        u, rows = self.velocity(pose, y), pose.rows
        slope, rest = self.law(mode)
        force = np.where(mode != 0, -slope * (rows @ u + pose.drive) - rest, 0.0)
        mass = np.array([self.mass, self.mass, pose.inertia[0]])
        turning = [self.mass * u[2] * u[1], -self.mass * u[2] * u[0]]
        load = np.array([*turning, -pose.inertia[1] * u[2] - pose.own[1]]) + rows.T @ force
        stuck = mode == 0
        if stuck.any():
            held = rows[stuck]
            miss = -pose.bias(u)[stuck] - held @ (load / mass)
            force[stuck] = solve((held / mass) @ held.T, miss)
            load = load + held.T @ force[stuck]
        return force, load / mass, u, pose

    def powers(self, y: Array, t_s: float, mode: Array) -> Array:
        """Return the joints' powers: T_i is the moment about joint i of all links up to it."""
        force, rate, u, pose = self.forces(y, t_s, mode)
        p, (arm, speed, second) = self.p, pose.arm
        left = np.array([-1.0, 1.0])
        accel = rate[:2] + u[2] * left * u[1::-1] + rate[2] * left * arm[:, ::-1]
        accel += -(u[2] ** 2) * arm + 2 * u[2] * left * speed[:, ::-1] + second
        push = p.mass_kg * accel - np.sum((force[:, None] * pose.axis).reshape(-1, 2, 2), 1)
        moment = np.cumsum(cross(arm, push) + p.inertia * (rate[2] + pose.turn[2]))
        joint = arm + p.half_length_m * pose.axis[::2]
        torque = moment - cross(joint, np.cumsum(push, 0))
        return -torque[:-1] * np.diff(pose.turn[1])

    def holds(self, y: Array, t_s: float, mode: Array) -> bool:
        """Tell whether the law allows a mode in a state."""
        force, _, u, pose = self.forces(y, t_s, mode)
        slip = pose.rows @ u + pose.drive
        ahead = (mode == 0) | ~self.modal | (slip * mode >= -1e-13 * self.speed)
        within = (force <= self.dry_back * (1 + 1e-12)) & (-force <= self.dry * (1 + 1e-12))
        return bool(np.all(ahead & ((mode != 0) | within)))


def solve(matrix: Array, right: Array) -> Array:
    """Return the least solution; wheels of a straight chain depend on one another."""
    return np.linalg.lstsq(matrix, right, rcond=1e-13)[0]


@dataclass(frozen=True)
class Step:
    """Hold a step: times, states and rates u' at its ends, and the mode."""

    start_s: float
    length_s: float
    states: tuple[Array, Array]
    rates: tuple[Array, Array]
    mode: Array

    def at(self, snake: Snake, x: float) -> Array:
        """Return the state at a fraction, by the cubic in u through both ends."""
        poses = [snake.pose(self.start_s + part * self.length_s) for part in (0.0, x, 1.0)]
        u0, u1 = snake.velocity(poses[0], self.states[0]), snake.velocity(poses[2], self.states[1])
        rise = [(1 + 2 * x) * (1 - x) ** 2, x * x * (3 - 2 * x)]
        tilt = [x * (1 - x) ** 2 * self.length_s, x * x * (x - 1) * self.length_s]
        u = rise[0] * u0 + rise[1] * u1 + tilt[0] * self.rates[0] + tilt[1] * self.rates[1]
        return np.array([u[0], u[1], poses[1].inertia[0] * u[2] + poses[1].own[0]])


def extrapolated(snake: Snake, y: Array, t_s: float, h: float, mode: Array) -> tuple[Array, Array]:
    """Return the state after h and how far two orders of it are apart, per component."""
    period = snake.gait.period_s
    most = 6 if h > 1e-3 * period else 4 if h > 1e-6 * period else 2
    start, rows = snake.pose(t_s), []
    for parts in range(1, most + 1):
        state, pose = y, start
        for k in range(parts):
            state, pose = snake.euler(state, t_s + k * h / parts, h / parts, mode, pose)
        row = [state]
        for k in range(1, parts):
            row.append(row[-1] + (row[-1] - rows[-1][k - 1]) / (parts / (parts - k) - 1))
        rows.append(row)
    return rows[-1][-1], np.abs(rows[-1][-1] - rows[-1][-2])


def cycle(snake: Snake, u0: Array, tolerance: float, longest: float = LONGEST) -> Iterator[Step]:
    """Yield the steps of a period from u0 = (Vx, Vy, w)."""
    period, pose = snake.gait.period_s, snake.pose(0.0)
    size = snake.mass * snake.speed * snake.p.links * snake.p.half_length_m
    scale = np.array([snake.speed, snake.speed, size, 1.0, *[snake.speed * period] * 2, np.inf])
    y = np.array([u0[0], u0[1], pose.inertia[0] * u0[2] + pose.own[0], 0.0, 0.0, 0.0, 0.0])
    t, h, shortest = 0.0, 1e-5 * period, SHORTEST * period
    mode = snake.kick(y, t, shortest, pose)
    while t < period * (1 - 1e-15):
        h = min(h, longest * period, period - t)
        end, gap = extrapolated(snake, y, t, h, mode)
        error = float(np.max(gap / scale)) / tolerance
        order = 6 if h > 1e-3 * period else 4 if h > 1e-6 * period else 2
        if error > 1:
            h *= max(0.2, 0.85 * error ** (-1 / order))
            continue
        rates = snake.forces(y, t, mode)[1], snake.forces(end, t + h, mode)[1]
        step = Step(t, h, (y, end), rates, mode)
        inner = (0.25, 0.5, 0.75) if h > 100 * shortest else ()
        held = snake.holds(end, t + h, mode)
        held = held and all(snake.holds(step.at(snake, x), t + x * h, mode) for x in inner)
        if held:
            yield step
            y, t = end, period if h == period - t else t + h
            h *= min(5.0, 0.85 * (error + 1e-12) ** (-1 / order))
        elif h > 1.01 * shortest:
            h = max(h / 3, shortest)
        else:
            mode = snake.kick(y, t, h, snake.pose(t))
            y, t = snake.euler(y, t, h, mode, snake.pose(t))[0], t + h
            h = 100 * shortest


@dataclass(frozen=True)
class Followed:
    """Hold what a period from a state makes: means, and how far the state comes back."""

    speed_m_s: float  # along the mean circle
    turn_rad_per_cycle: float
    power_w: float
    positive_power_w: float
    gap: float  # |u(T) - u(0)| over omega l alpha, spin by the body's length


def follow(
    p: Params, gait: Gait, u0: Array, tolerance: float = 1e-9, longest: float = LONGEST
) -> Followed:
    """Return the means over the period from a state, and what it is off from itself after it."""
    snake, period = Snake(p, gait), gait.period_s
    steps = list(cycle(snake, u0, tolerance, longest))
    positive = sum(positive_work(snake, step) for step in steps)
    last = steps[-1].states[1]
    circling = Snake(p, gait, last[3] / period)
    *_, arc = cycle(circling, u0, tolerance, longest=1 / 40)
    gap = snake.velocity(snake.pose(period), last) - u0
    gap *= np.array([1, 1, p.links * p.half_length_m]) / snake.speed
    return Followed(
        speed_m_s=float(np.hypot(*arc.states[1][4:6])) / period,
        turn_rad_per_cycle=float(last[3]),
        power_w=float(last[6]) / period,
        positive_power_w=positive / period,
        gap=float(np.abs(gap).max()),
    )


def positive_work(snake: Snake, step: Step) -> float:
    """Return the integral of sum P_i^+ over a step, J; a power that changes sign by its quartic."""
    places = (NODES + 1) / 2
    values = np.array(
        [
            snake.powers(step.at(snake, x), step.start_s + x * step.length_s, step.mode)
            for x in places
        ]
    )
    total = step.length_s / 2 * (WEIGHTS @ np.maximum(values, 0))
    fine = np.linspace(-1, 1, 401)
    for joint in np.flatnonzero((values > 0).any(0) & (values < 0).any(0)):
        curve = np.polyval(np.polyfit(NODES, values[:, joint], 4), fine)
        total[joint] = step.length_s / 2 * ramp(curve, fine[1] - fine[0])
    return float(total.sum())


def ramp(values: Array, apart: float) -> float:
    """Return the integral of the positive part of the line through values."""
    a, b = values[:-1], values[1:]
    rise = np.where(a * b < 0, np.maximum(a, b) ** 2 / (np.abs(a - b) + 1e-300), 0.0)
    return float(apart / 2 * np.sum(np.where(a * b < 0, rise, np.maximum(a + b, 0.0))))
