"""Set-valued (Bingham, Coulomb) friction without smoothing: smooth motion between switching events.

Each link has two contacts, along and across. A contact slips with a sign (force -C v - F_0 s) or
sticks (v = 0, force within [-F_0, F_0], found as the multiplier of v' = 0); C and F_0 along a link
may be others backwards. DOP853 runs between
events; at each event the modes of the contacts at rest are chosen by trying every combination and
keeping the one that obeys the law, which is unique because the friction is a convex potential.
Angles driven, flat ground, body-frame velocities u as in body_frame.py.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy.integrate import DOP853
from scipy.optimize import brentq

from . import body_frame as bf
from .params import Array, Gait, Params

SLACK_M_S = 1e-10  # below it a contact that touched zero is still counted as at rest
PIECES = 5  # looks for events inside each step


@dataclass(frozen=True)
class Contacts:
    """Hold slip velocities v = rows u + drive of all contacts (2n,), tail link first, and slopes.

    Their rates are v' = rows u' + bias.
    """

    rows: Array  # (2n, 3)
    slip: Array  # (2n,)
    bias: Array  # (2n,)


def contacts_at(shape: bf.Shape, u: Array) -> Contacts:
    """Return the contacts' velocities and what their rates need."""
    axis = np.stack([shape.tangent, shape.normal], 1)  # (n, 2, 2)
    turning = bf.across(axis) * shape.psi[1][:, None, None]
    place, rate, second = (part[:, None, :] for part in shape.place)
    lever, lever_rate = (np.sum(axis * bf.across(arm), -1, keepdims=True) for arm in (place, rate))
    rows = np.concatenate([axis, lever], -1).reshape(-1, 3)
    tilt = np.sum(turning * bf.across(place), -1, keepdims=True) + lever_rate
    rows_rate = np.concatenate([turning, tilt], -1).reshape(-1, 3)
    drive_rate = np.sum(turning * rate + axis * second, -1).ravel()
    drive = np.sum(axis * rate, -1).ravel()
    return Contacts(rows, rows @ u + drive, rows_rate @ u + drive_rate)


@dataclass(frozen=True)
class System:
    """Hold a snake under a gait on set-valued ground."""

    p: Params
    gait: Gait

    @property
    def viscous(self) -> Array:
        """Return C of every contact that slips forwards or to the left, (2n,)."""
        return np.tile([self.p.ct, self.p.cn], self.p.links)

    @property
    def viscous_back(self) -> Array:
        """Return C of every contact that slips the other way, (2n,)."""
        return np.tile([self.p.backwards[0], self.p.cn], self.p.links)

    @property
    def threshold(self) -> Array:
        """Return F_0 of every contact that slips forwards or to the left, (2n,)."""
        return np.tile([self.p.ft0, self.p.fn0], self.p.links)

    @property
    def threshold_back(self) -> Array:
        """Return F_0 of every contact that slips the other way, (2n,)."""
        return np.tile([self.p.backwards[1], self.p.fn0], self.p.links)

    @property
    def grips(self) -> Array:
        """Tell which contacts can stick, (2n,)."""
        return self.threshold + self.threshold_back > 0

    @property
    def switches(self) -> Array:
        """Tell which contacts have modes, (2n,): those that stick, or slip in two ways."""
        return self.grips | (self.viscous != self.viscous_back)

    def slack(self, force: Array) -> Array:
        """Return how far holding forces (2n,) are from what makes their contacts give way."""
        return np.where(force > 0, self.threshold_back - force, self.threshold + force)

    def slipping(self, slip: Array, mode: Array) -> Array:
        """Return the forces (2n,) on contacts that slip in a mode."""
        viscous = np.where(mode < 0, self.viscous_back, self.viscous)
        return -viscous * slip - np.where(mode < 0, self.threshold_back, self.threshold) * mode

    def forces(self, t_s: float, u: Array, mode: Array) -> tuple[Array, Array, Contacts, bf.Shape]:
        """Return u', contact forces (2n,), contacts and shape in a mode (2n,) of -1, 0, +1."""
        p, shape = self.p, bf.shape_at(self.p, self.gait, t_s)
        touch = contacts_at(shape, u)
        stuck = (mode == 0) & self.grips
        force = np.where(stuck, 0.0, self.slipping(touch.slip, mode))
        load = bf.resultant(shape, -p.mass_kg * bf.known_accelerations(shape, u))
        load[2] -= p.inertia * shape.psi[2].sum()
        inverse = np.linalg.inv(bf.mass_matrix(p, shape))
        free = inverse @ (load + touch.rows.T @ force)
        rows = touch.rows[stuck]
        if len(rows):
            response = rows @ inverse @ rows.T
            hold = np.linalg.solve(response, -(rows @ free + touch.bias[stuck]))
            force[stuck] = hold
            free = free + inverse @ rows.T @ hold
        return free, force, touch, shape

    def rate(self, t_s: float, y: Array, mode: Array) -> Array:
        """Return y' of y = (u, heading, x, y of link 1), (6,)."""
        cos, sin = np.cos(y[3]), np.sin(y[3])
        travel = [y[2], cos * y[0] - sin * y[1], sin * y[0] + cos * y[1]]
        return np.concatenate([self.forces(t_s, y[:3], mode)[0], travel])

    def choose(self, t_s: float, u: Array, mode: Array, resting: Array) -> Array:
        """Return the mode whose resting contacts (indices) obey the friction law from now on."""
        candidates = []
        for trial in product((0, 1, -1), repeat=len(resting)):
            candidate = mode.copy()
            candidate[resting] = trial
            if np.sum((candidate == 0) & self.grips) <= 3:
                candidates.append((self.margin(t_s, u, candidate, resting), candidate))
        margin, best = max(candidates, key=lambda pair: pair[0])
        if margin < -1e-6 * self.threshold.max():
            raise RuntimeError(f"no contact mode at t = {t_s}: margin {margin} N")
        return best

    def margin(self, t_s: float, u: Array, mode: Array, resting: Array) -> float:
        """Return how clearly a mode obeys the law: its least slack in units of force."""
        try:
            u_dot, force, touch, _ = self.forces(t_s, u, mode)
        except np.linalg.LinAlgError:
            return -np.inf
        grip = self.slack(force)[resting]
        onset = self.p.mass_kg * mode[resting] * (touch.rows @ u_dot + touch.bias)[resting]
        return float(np.where(mode[resting] == 0, grip, onset).min(initial=np.inf))


@dataclass(frozen=True)
class Piece:
    """Hold a smooth stretch of motion: y(t) for start <= t <= end, in one mode."""

    start_s: float
    end_s: float
    mode: Array
    at: Callable[[float], Array]


def settle_on_contacts(system: System, t_s: float, y: Array, stuck: Array) -> Array:
    """Return y with u moved (by rounding errors) so that the stuck contacts are exactly at rest."""
    touch = contacts_at(bf.shape_at(system.p, system.gait, t_s), y[:3])
    if stuck.any():
        y = y.copy()
        y[:3] -= np.linalg.lstsq(touch.rows[stuck], touch.slip[stuck], rcond=None)[0]
    return y


def first_modes(system: System, t_s: float, u: Array) -> Array:
    """Return the modes of a state without history."""
    slip = contacts_at(bf.shape_at(system.p, system.gait, t_s), u).slip
    mode = np.sign(slip).astype(int)
    mode[(mode == 0) & ~system.grips] = 1
    resting = np.flatnonzero((np.abs(slip) < SLACK_M_S) & system.grips)
    return system.choose(t_s, u, mode, resting)


def alarms(system: System, t_s: float, y: Array, mode: Array) -> Array:
    """Return one number a contact (2n,), negative once its mode has ended."""
    _, force, touch, _ = system.forces(t_s, y[:3], mode)
    ends = np.where(mode == 0, system.slack(force), mode * touch.slip)
    return np.where(system.switches, ends, 1.0)


def run(
    system: System, y: Array, start_s: float, end_s: float, *, rtol: float = 1e-10
) -> Iterator[Piece]:
    """Yield the smooth pieces of the motion from y (6,) at start_s to end_s."""
    y, mode = np.asarray(y, float), first_modes(system, start_s, y[:3])
    t, began, longest, stalled = start_s, None, system.gait.period_s / 200, 0
    while t < end_s:
        stalled = stalled + 1 if t == began else 0
        if stalled > 3 * system.p.links:
            raise RuntimeError(f"contact modes do not settle at t = {t}: {mode}")
        began = t
        y = settle_on_contacts(system, t, y, (mode == 0) & system.grips)
        solver = DOP853(
            lambda s, z, held=mode: system.rate(s, z, held),
            t,
            y,
            end_s,
            max_step=longest,
            rtol=rtol,
            atol=rtol * 1e-2,
        )
        armed = alarms(system, t, y, mode) > SLACK_M_S
        ended = False
        while solver.status == "running" and not ended:
            message = solver.step()
            if solver.status == "failed":
                raise RuntimeError(message)
            track, before = solver.dense_output(), solver.t_old
            found = first_event(system, track, (before, solver.t), mode, armed)
            t, y = (solver.t, solver.y) if found is None else (found[0], track(found[0]))
            if t > before:
                yield Piece(before, t, mode, track)
            if found is not None:
                mode, ended = switch(system, t, y, mode, found[1]), True
        if not ended:
            return


def first_event(
    system: System, track: Callable, span: tuple[float, float], mode: Array, armed: Array
) -> tuple[float, int] | None:
    """Return time and contact of the first mode that ends on a step, or None; updates `armed`.

    A contact that has just changed its mode starts at its own limit and is armed once it has left.
    """
    previous = span[0]
    for now in np.linspace(*span, PIECES + 1)[1:]:
        value = alarms(system, now, track(now), mode)
        ending = np.flatnonzero(np.where(armed, value < 0, value < -SLACK_M_S))
        hits = [(crossing(system, track, (previous, now), mode, k), k) for k in ending]
        if hits:
            return min(hits)
        armed |= value > SLACK_M_S
        previous = now
    return None


def crossing(
    system: System, track: Callable, span: tuple[float, float], mode: Array, contact: int
) -> float:
    """Return when a contact's alarm turns negative; it is negative at the end of the span.

    A contact that has only just left its limit may come back at once, so the look-out for a
    positive value closes in on the start of the span.
    """

    def alarm(t: float) -> float:
        return alarms(system, t, track(t), mode)[contact]

    start, late = span
    for halving in range(40):
        early = start if halving == 0 else start + (span[1] - start) * 0.5**halving
        if alarm(early) > 0:
            return brentq(alarm, early, late, xtol=1e-15, rtol=1e-14)
        late = early if halving > 0 else late
    return start


def switch(system: System, t_s: float, y: Array, mode: Array, contact: int) -> Array:
    """Return the modes after one contact's mode has ended."""
    if mode[contact] == 0:  # the grip is at its limit: it gives way in the direction it was pulled
        released = mode.copy()
        force = system.forces(t_s, y[:3], mode)[1][contact]
        released[contact] = -int(np.sign(force))
        return released
    if not system.grips[contact]:  # nothing holds it: it goes on, the other way
        passed = mode.copy()
        passed[contact] *= -1
        return passed
    slip = contacts_at(bf.shape_at(system.p, system.gait, t_s), y[:3]).slip
    resting = (mode == 0) | (np.abs(slip) < SLACK_M_S)  # symmetry brings contacts to rest in pairs
    resting[contact] = True
    return system.choose(t_s, y[:3], mode, np.flatnonzero(resting & system.grips))
