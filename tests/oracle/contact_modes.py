"""Set-valued friction with free joints: all links' own coordinates, constraints, and events.

A link has its own (x, y, theta). Pinned joints and resting contacts are constraints with
multipliers, one dense system; torques or servos turn the joints. A contact (a wheel along or
across its link, a gear) rests or slides with a sign. SciPy's DOP853 runs between events, which
are found on its dense output. Which contacts rest from then on is a bounded least squares problem
(Gauss's principle), left to SciPy. Where more contacts rest than there are freedoms, a linear
program says how much of the friction rest takes. Kinks of a servo's law end a piece, too.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from scipy.integrate import DOP853
from scipy.linalg import null_space, qr
from scipy.optimize import brentq, linprog, lsq_linear

from .dense import gap_rows, joint_gaps
from .params import Array, Gait, Params

AT_REST_M_S = 1e-10  # below it a contact that touched zero counts as at rest
LOOKS = 6  # for events inside a step
MOST_AT_ONCE = 60


class Drive:
    """Give torques of time: rows between which they are linear."""

    def __init__(self, t_s: Array, torque_nm: Array) -> None:
        self.t_s, self.torque_nm = np.asarray(t_s), np.asarray(torque_nm)
        self.rotor = self.gear_dry = 0.0

    def breaks(self, end_s: float) -> Array:
        """Return the times at which the law changes of itself."""
        return self.t_s[(self.t_s > 0) & (self.t_s < end_s)]

    def enter(self, t: float, phi: Array, rate: Array) -> None:
        """Take note of the state at a break."""

    def kinks(self, phi: Array, rate: Array) -> tuple[Array, Array]:
        """Return values (K,) and the limits (K, 2) at which the law has kinks."""
        return np.zeros(0), np.zeros((0, 2))

    def torques(self, t: float, phi: Array, rate: Array, region: Array) -> Array:
        """Return T (n-1,) on each link from the next, N m."""
        return np.array([np.interp(t, self.t_s, row) for row in self.torque_nm.T])


@dataclass
class ServoDrive:
    """Turn joints by servos towards setpoints (frames, n-1), rad; fields as sn.Servo has them."""

    servo: object
    setpoints: Array
    frame_s: float = 0.02
    goal: Array = field(default_factory=lambda: np.zeros(0))
    held: Array = field(default_factory=lambda: np.zeros(0))

    @property
    def rotor(self) -> float:
        """Return the rotor's inertia at the joint, kg m^2."""
        return self.servo.armature_kg_m2

    @property
    def gear_dry(self) -> float:
        """Return the gear's dry friction, N m."""
        return self.servo.gear_friction_nm

    def breaks(self, end_s: float) -> Array:
        """Return when setpoints or held duties change."""
        frames = np.arange(1, int(end_s / self.frame_s) + 1) * self.frame_s
        hz = self.servo.update_hz
        looks = np.arange(1, int(end_s * hz) + 1) / hz if hz else np.zeros(0)
        every = np.sort(np.concatenate([frames, looks]))
        every = every[np.concatenate([[True], np.diff(every) > 1e-9])]
        return every[every < end_s - 1e-9]

    def enter(self, t: float, phi: Array, rate: Array) -> None:
        """Take the setpoints of the frame, and the duty where the loop looks now."""
        self.goal = self.setpoints[int(t / self.frame_s + 1e-6)]
        hz = self.servo.update_hz
        if hz and abs(t * hz - round(t * hz)) < 1e-6:
            error = self.goal - phi
            dead = error - np.clip(error, -self.servo.dead_band_rad, self.servo.dead_band_rad)
            self.held = np.clip(self._wish(dead, rate), -1, 1)

    def _wish(self, error: Array, rate: Array) -> Array:
        s = self.servo
        asked = s.stiffness_nm_rad * error - s.damping_nms_rad * rate
        return asked / s.torque_limit_nm + rate / s.speed_limit_rad_s

    def _beyond(self, phi: Array, region: Array) -> Array:
        error, dead = self.goal - phi, self.servo.dead_band_rad
        return np.where(region == 0, 0.0 if dead else error, error - region * dead)

    def _volts(self, duty: Array, rate: Array) -> float:
        s = self.servo
        back = 1 + s.supply_sag * np.sum(duty * rate) / s.speed_limit_rad_s
        return back / (1 + s.supply_sag * np.sum(duty**2))

    def kinks(self, phi: Array, rate: Array) -> tuple[Array, Array]:
        """Return errors, wished duties and the supply, each with its limits."""
        s, n = self.servo, phi.size
        error = self.goal - phi
        dead = error - np.clip(error, -s.dead_band_rad, s.dead_band_rad)
        wish = self._wish(dead, rate)
        duty = self.held if s.update_hz else np.clip(wish, -1, 1)
        far = np.inf if s.update_hz or not s.dead_band_rad else s.dead_band_rad
        top = np.inf if s.update_hz else 1.0
        limits = np.repeat([[-far, far], [-top, top]], n, axis=0)
        supply = [0.0, 1.0] if s.supply_sag else [-np.inf, np.inf]
        values = np.concatenate([error, wish, [self._volts(duty, rate)]])
        return values, np.vstack([limits, supply])

    def torques(self, t: float, phi: Array, rate: Array, region: Array) -> Array:
        """Return the motors' torques on the links before the joints, the gear's damping in it."""
        s, n = self.servo, phi.size
        if s.update_hz:
            duty = self.held
        else:
            wish = self._wish(self._beyond(phi, region[:n]), rate)
            duty = np.where(region[n : 2 * n] == 0, wish, region[n : 2 * n])
        volts = self._volts(duty, rate) if region[-1] == 0 else float(region[-1] > 0)
        motor = s.torque_limit_nm * (volts * duty - rate / s.speed_limit_rad_s)
        return -(motor - s.gear_damping_nms_rad * rate)


@dataclass
class Mode:
    """Hold what each contact does (0 rests, +1, -1 slides so) and where the drive's law is."""

    slide: Array
    region: Array
    basis: Array = field(default_factory=lambda: np.zeros(0, int))  # resting, independent

    @property
    def redundant(self) -> bool:
        """Tell whether more contacts rest than there are freedoms for."""
        return self.basis.size < np.sum(self.slide == 0)


@dataclass
class World:
    """Hold a robot on its ground, and what turns its joints."""

    p: Params
    drive: Drive | ServoDrive

    def __post_init__(self) -> None:
        p, n = self.p, self.p.links
        self.turns = np.zeros((n - 1, 3 * n))  # rows of the joints' rates
        for i in range(n - 1):
            self.turns[i, 3 * i + 2], self.turns[i, 3 * i + 5] = -1, 1
        self.mass = np.diag(np.tile([p.mass_kg, p.mass_kg, p.inertia], n))
        self.mass += self.drive.rotor * self.turns.T @ self.turns
        gears = [self.drive.gear_dry] * (n - 1) if self.drive.gear_dry else []
        self.ahead = np.array([p.ft0, p.fn0] * n + gears)  # bound of those that slide with +
        self.back = np.array([p.backwards[1], p.fn0] * n + gears)
        self.viscous = np.array([p.ct, p.cn] * n + [0.0] * len(gears))
        self.viscous_back = np.array([p.backwards[0], p.cn] * n + [0.0] * len(gears))
        self.grips = self.ahead + self.back > 0
        self.switches = self.grips | (self.viscous != self.viscous_back)

    def closing(self, t: float, q: Array, v: Array) -> tuple[Array, Array, Array, Array]:
        """Return the constraints' gaps, rows, rates, and part of the second rate without q''."""
        pose, rates = q.reshape(-1, 3), v.reshape(-1, 3)
        gap, _ = joint_gaps(self.p, pose, rates)
        rows, bend = gap_rows(self.p, pose, rates)
        return gap.ravel(), rows, 0 * bend, bend

    def contacts(self, q: Array, v: Array) -> tuple[Array, Array]:
        """Return the contacts' rows (slip = rows v) and the part of slip' without v'."""
        n, a, w = self.p.links, q[2::3], v[2::3]
        rows, bias = np.zeros((2 * n, 3 * n)), np.zeros(2 * n)
        for i in range(n):
            c, s = np.cos(a[i]), np.sin(a[i])
            rows[2 * i, 3 * i : 3 * i + 2], rows[2 * i + 1, 3 * i : 3 * i + 2] = (c, s), (-s, c)
            bias[2 * i] = w[i] * rows[2 * i + 1] @ v
            bias[2 * i + 1] = -w[i] * rows[2 * i] @ v
        if self.drive.gear_dry:
            rows, bias = np.vstack([rows, self.turns]), np.append(bias, np.zeros(n - 1))
        return rows, bias

    def pushes(self, t: float, q: Array, v: Array, mode: Mode, rows: Array) -> Array:
        """Return all forces (3n,) but those of joints and of resting contacts."""
        p, slip = self.p, rows @ v
        force = np.zeros(3 * p.links)
        force[0::3], force[1::3] = p.mass_kg * np.asarray(p.gravity_m_s2)
        force -= self.turns.T @ self.drive.torques(t, self.turns @ q, self.turns @ v, mode.region)
        return force - rows.T @ self.drag(slip, mode)

    def drag(self, slip: Array, mode: Mode) -> Array:
        """Return what holds back each contact that slides, N."""
        back = np.where(mode.slide == 0, slip < 0, mode.slide < 0)
        drag = np.where(back, self.viscous_back, self.viscous) * slip
        return drag + np.where(back, self.back, self.ahead) * mode.slide

    def solve(self, t: float, y: Array, mode: Mode) -> tuple[Array, Array, Array, Array]:
        """Return v', the forces of resting contacts in the basis, all rows, all slips' rates."""
        q, v = np.split(y, 2)
        _, rows, _, bend = self.closing(t, q, v)
        touch, bias = self.contacts(q, v)
        held = np.vstack([rows, touch[mode.basis]])
        k, m = held.shape
        matrix = np.block([[self.mass, -held.T], [held, np.zeros((k, k))]])
        right = [self.pushes(t, q, v, mode, touch), -bend, -bias[mode.basis]]
        found = np.linalg.solve(matrix, np.concatenate(right))
        return found[:m], found[m + len(rows) :], touch, touch @ found[:m] + bias

    def rate(self, t: float, y: Array, mode: Mode) -> Array:
        """Return y' of y = (q, v)."""
        return np.concatenate([y[y.size // 2 :], self.solve(t, y, mode)[0]])

    def alarms(self, t: float, y: Array, mode: Mode) -> Array:
        """Return numbers that turn negative where the mode ends: contacts, then kinks."""
        q, v = np.split(y, 2)
        accel, force, touch, _ = self.solve(t, y, mode)
        ends = np.where(self.switches & (mode.slide != 0), mode.slide * (touch @ v), 1.0)
        if mode.redundant:
            resting = np.flatnonzero(mode.slide == 0)
            ends[resting] = self._rest_left(t, y, mode, accel, touch, resting)
            # a pose may be singular (two straight links): behind it they are independent
            other = np.setdiff1d(resting, mode.basis)
            ends[other] = np.minimum(ends[other], 1 - abs(touch[other] @ v) / AT_REST_M_S)
        else:
            ends[mode.basis] = _slack(force, self.ahead[mode.basis], self.back[mode.basis])
        value, limit = self.drive.kinks(self.turns @ q, self.turns @ v)
        inside = np.where(mode.region > 0, value - limit[:, 1], limit[:, 0] - value)
        within = np.minimum(value - limit[:, 0], limit[:, 1] - value)
        return np.concatenate([ends, np.where(mode.region == 0, within, inside)])

    def _rest_left(
        self, t: float, y: Array, mode: Mode, accel: Array, touch: Array, resting: Array
    ) -> float:
        """Return 1 less the share of their bounds that the resting contacts need at least."""
        q, v = np.split(y, 2)
        free = null_space(self.closing(t, q, v)[1])
        need = free.T @ (self.mass @ accel - self.pushes(t, q, v, mode, touch))
        k = resting.size
        up, down = self.back[resting], self.ahead[resting]
        goal = np.append(np.zeros(k), 1.0)
        equal = np.hstack([free.T @ touch[resting].T, np.zeros((free.shape[1], 1))])
        within = np.vstack(
            [np.hstack([np.eye(k), -up[:, None]]), np.hstack([-np.eye(k), -down[:, None]])]
        )
        found = linprog(goal, within, np.zeros(2 * k), equal, need, (None, None), method="highs")
        return 1 - found.fun if found.status == 0 else -1.0

    def settle(self, t: float, y: Array, slide: Array) -> Array:
        """Return y with joints closed and what rests at rest: rounding errors go."""
        q, v = np.split(y.copy(), 2)
        for _ in range(3):
            gap, rows, _, _ = self.closing(t, q, v)
            q = q - np.linalg.lstsq(rows, gap, rcond=None)[0]
        _, rows, rate, _ = self.closing(t, q, v)
        touch = self.contacts(q, v)[0][slide == 0]
        goal = np.concatenate([rate, np.zeros(len(touch))])
        rows = np.vstack([rows, touch])
        for _ in range(2):
            v = v - np.linalg.lstsq(rows, rows @ v - goal, rcond=1e-11)[0]
        return np.concatenate([q, v])

    def region(self, y: Array) -> Array:
        """Return where the drive's law is, -1, 0, 1 for each of its kinks."""
        q, v = np.split(y, 2)
        value, limit = self.drive.kinks(self.turns @ q, self.turns @ v)
        return (value > limit[:, 1]).astype(int) - (value < limit[:, 0])

    def choose(self, t: float, y: Array, slide: Array, resting: Array, region: Array) -> Mode:
        """Return the mode from now on: of contacts without speed, which rest and which go."""
        q, v = np.split(y, 2)
        slide = slide.copy()
        slide[resting] = 0
        touch, bias = self.contacts(q, v)
        _, rows, _, bend = self.closing(t, q, v)
        free = null_space(rows)
        first = -np.linalg.lstsq(rows, bend, rcond=None)[0]
        push = self.pushes(t, q, v, Mode(slide, region), touch)
        inner = np.linalg.cholesky(free.T @ self.mass @ free)
        ways = touch[resting] @ free
        # shift the accelerations so that what the contacts' rows turn is in them, but for what no
        # motion can take up: in a singular pose, where a contact must reverse
        turning = touch[resting] @ first + bias[resting]
        shift = -np.linalg.lstsq(ways, turning, rcond=1e-11)[0]
        first, turning = first + free @ shift, turning + ways @ shift
        load = np.linalg.solve(inner, free.T @ (push - self.mass @ first))
        answer = np.linalg.solve(inner, ways.T)
        scale = np.maximum(np.maximum(self.ahead, self.back)[resting], 1e-300)
        low, high = -self.ahead[resting] / scale, self.back[resting] / scale
        part = np.zeros(resting.size)
        if resting.size:
            rows, goal = answer * scale, -load
            if abs(turning).max() > 1e-9 * (1 + abs(bias).max()):
                soft = 1e-5 * np.linalg.norm(rows)
                rows = np.vstack([rows, soft * np.eye(resting.size)])
                goal = np.append(goal, -scale * turning / soft)
            limits = (low - 1e-300, high + 1e-300)
            part = lsq_linear(rows, goal, limits, method="bvls", tol=1e-15).x
        slide[resting[part >= high - 1e-9]] = -1
        slide[resting[part <= low + 1e-9]] = 1
        stays = np.flatnonzero(slide == 0)
        basis = stays
        if stays.size:
            _, upper, order = qr((touch[stays] @ free).T, mode="economic", pivoting=True)
            size = abs(np.diag(upper))
            basis = np.sort(stays[order[: int(np.sum(size > 1e-8 * size.max()))]])
        return Mode(slide, region, basis)

    def first_mode(self, t: float, y: Array) -> Mode:
        """Return the mode of a state without history."""
        q, v = np.split(y, 2)
        slip = self.contacts(q, v)[0] @ v
        resting = np.flatnonzero((abs(slip) < AT_REST_M_S) & self.grips)
        slide = np.where(slip < 0, -1, 1)
        return self.choose(t, y, slide, resting, self.region(y))


@dataclass
class SpringWorld(World):
    """Hold links on springs of k, c between their ends, N/m and N s/m; joints follow the gait."""

    gait: Gait
    stiffness: float
    damping: float

    def closing(self, t: float, q: Array, v: Array) -> tuple[Array, Array, Array, Array]:
        """Return what holds the joint angles on the gait, as World.closing does the joints."""
        phi, rate, second = self.gait.angles(t, self.p.links - 1)
        return self.turns @ q - phi, self.turns, rate, -second

    def pushes(self, t: float, q: Array, v: Array, mode: Mode, rows: Array) -> Array:
        """Return all forces (3n,) but those of the drive and of resting contacts."""
        gap, opening, _, _ = super().closing(t, q, v)
        force = self.stiffness * gap + self.damping * opening @ v
        return super().pushes(t, q, v, mode, rows) - opening.T @ force


def _slack(force: Array, ahead: Array, back: Array) -> Array:
    """Return how much of its bound each holding force leaves, relative."""
    return np.where(force > 0, back - force, ahead + force) / np.maximum(ahead, back)


def pieces(
    world: World, y: Array, end_s: float, *, rtol: float = 1e-12, longest_s: float = 0.01
) -> Iterator[tuple[float, Callable[[float], Array], Mode]]:
    """Yield each smooth piece from y at t = 0 on: its end, its dense output (q, v), its mode."""
    mode = None
    for start, stop in pairwise([0.0, *world.drive.breaks(end_s), end_s]):
        q, v = np.split(y, 2)
        world.drive.enter(start, world.turns @ q, world.turns @ v)
        if mode is None:
            mode = world.first_mode(start, y)
        else:
            resting = np.flatnonzero(mode.slide == 0)
            mode = world.choose(start, y, mode.slide, resting, world.region(y))
        for piece in _pieces(world, start, stop, y, mode, rtol, longest_s):
            until, track, y, after = piece
            yield until, track, mode
            mode = after


def run(
    world: World, y: Array, times_s: Array, *, rtol: float = 1e-12, longest_s: float = 0.01
) -> Iterator[Array]:
    """Yield (q, v), all links' (x, y, theta) and rates, at the times, from y at t = 0."""
    due = list(times_s)
    for until, track, _ in pieces(world, y, due[-1], rtol=rtol, longest_s=longest_s):
        while due and due[0] <= until:
            yield track(due.pop(0))


def _pieces(
    world: World, t: float, stop: float, y: Array, mode: Mode, rtol: float, longest_s: float
) -> Iterator[tuple[float, Callable[[float], Array], Array, Mode]]:
    """Yield each smooth step: its end, its dense output, the state and the mode behind it."""
    at_once = 0
    while t < stop:
        y = world.settle(t, y, mode.slide)
        solver = DOP853(
            lambda s, z, held=mode: world.rate(s, z, held),
            t,
            y,
            stop,
            max_step=longest_s,
            rtol=rtol,
            atol=rtol / 100,
        )
        began, armed = t, world.alarms(t, y, mode) > AT_REST_M_S
        ended = None
        while solver.status == "running" and ended is None:
            if message := solver.step():
                raise RuntimeError(message)
            track = solver.dense_output()
            ended = _first_end(world, track, (solver.t_old, solver.t), mode, armed)
            t, y = (solver.t, solver.y) if ended is None else (ended[0], track(ended[0]))
            after = mode if ended is None else _switched(world, t, y, mode, ended[1])
            yield t, track, y, after
        if ended is not None:
            mode = after
            at_once = at_once + 1 if t - began < 1e-11 else 0
            if at_once > MOST_AT_ONCE:
                raise RuntimeError(f"modes do not settle at t = {t}: {mode}")


def _switched(world: World, t: float, y: Array, mode: Mode, which: int) -> Mode:
    """Return the mode behind the end of one of its parts."""
    contacts = mode.slide.size
    slide, region = mode.slide, mode.region.copy()
    resting = slide == 0
    if which >= contacts:
        q, v = np.split(y, 2)
        value, limit = world.drive.kinks(world.turns @ q, world.turns @ v)
        k = which - contacts
        side = 1 if abs(value[k] - limit[k, 1]) < abs(value[k] - limit[k, 0]) else -1
        region[k] = side if region[k] == 0 else 0
        return Mode(slide, region, mode.basis)
    if world.grips[which]:
        resting = resting.copy()
        resting[which] = True
        q, v = np.split(y, 2)
        slip = world.contacts(q, v)[0] @ v
        resting |= world.grips & (abs(slip) < AT_REST_M_S)
        return world.choose(t, y, slide, np.flatnonzero(resting), region)
    slide = slide.copy()
    slide[which] = -slide[which]
    return Mode(slide, region, mode.basis)


def _first_end(
    world: World, track: Callable, span: tuple[float, float], mode: Mode, armed: Array
) -> tuple[float, int] | None:
    """Return time and index of the first alarm on a step, or None; updates `armed`."""
    before = span[0]
    for now in np.linspace(*span, LOOKS + 1)[1:]:
        value = world.alarms(now, track(now), mode)
        hits = np.flatnonzero(np.where(armed, value < 0, value < -AT_REST_M_S))
        if hits.size:
            return min((_crossing(world, track, (before, now), mode, k), k) for k in hits)
        armed |= value > AT_REST_M_S
        before = now
    return None


def _crossing(
    world: World, track: Callable, span: tuple[float, float], mode: Mode, k: int
) -> float:
    """Return when an alarm, negative at the end of the span, turns negative."""

    def alarm(t: float) -> float:
        return float(world.alarms(t, track(t), mode)[k])

    start, late = span
    for _ in range(50):  # what has only just left its limit may come back: look close behind it
        if alarm(start) > 0:
            return float(brentq(alarm, start, late, xtol=1e-15, rtol=1e-15))
        start = span[0] + (late - span[0]) / 2
        if alarm(start) <= 0:
            start, late = span[0], start
    return span[0]
