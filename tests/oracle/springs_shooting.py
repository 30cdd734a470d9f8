"""Periodic states of random robots with springs in their joints, by shooting with plain steps.

Written from the balance of each link (Eqs. 51-56, joint angles imposed), beside implicit.py and
with nothing of it: classical Runge-Kutta with equal steps, all columns of the map's derivative by
differences in one batch, Newton's method on the whole period; twice the steps until two agree.
`python -m tests.oracle.springs_shooting` writes periodic_springs.csv (minutes).
"""

from __future__ import annotations

import csv
import math
import sys
from dataclasses import asdict, dataclass, fields
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
FILE = Path(__file__).with_name("periodic_springs.csv")


@dataclass(frozen=True)
class Case:
    """Hold a robot, its ground, gait and springs, SI; half_m is half a link's length."""

    links: int
    mass_kg: float
    half_m: float
    ct: float
    cn: float
    alpha_rad: float
    beta_rad: float
    omega_rad_s: float
    stiffness_n_m: float
    damping_n_s_m: float

    @property
    def period_s(self) -> float:
        """Return the period of the gait."""
        return 2 * math.pi / self.omega_rad_s

    def joints(self, t_s: float) -> tuple[Array, Array, Array]:
        """Return each link's angle beyond link 1's, and its two rates, (n,) each."""
        phase = self.omega_rad_s * t_s + self.beta_rad * np.arange(self.links - 1)
        waves = self.alpha_rad * np.array([np.sin(phase), np.cos(phase), -np.sin(phase)])
        turns = np.zeros((3, self.links))
        turns[:, 1:] = np.cumsum(waves, 1) * self.omega_rad_s ** np.arange(3)[:, None]
        return turns[0], turns[1], turns[2]


def rates(case: Case, t_s: float, y: Array) -> tuple[Array, Array, Array]:
    """Return dy/dt, powers (batch, n - 1) and friction's (batch,) of states y (batch, 4n + 2).

    A state holds places (n, 2), link 1's angle, velocities (n, 2), link 1's rate.
    """
    n, m, half = case.links, case.mass_kg, case.half_m
    inertia = m * half * half / 3
    s, s1, s2 = case.joints(t_s)
    place, velocity = y[:, : 2 * n].reshape(-1, n, 2), y[:, 2 * n + 1 : -1].reshape(-1, n, 2)
    angle, spin = y[:, 2 * n, None] + s, y[:, -1, None] + s1
    along = np.stack([np.cos(angle), np.sin(angle)], -1)
    left = np.stack([-along[..., 1], along[..., 0]], -1)
    swing = spin[..., None] * left
    gap = place[:, 1:] - place[:, :-1] - half * (along[:, 1:] + along[:, :-1])
    gap_rate = velocity[:, 1:] - velocity[:, :-1] - half * (swing[:, 1:] + swing[:, :-1])
    force = np.zeros((len(y), n + 1, 2))  # from link i + 1 on link i; none beyond the ends
    force[:, 1:-1] = case.stiffness_n_m * gap + case.damping_n_s_m * gap_rate
    forwards, sideways = np.sum(velocity * along, -1), np.sum(velocity * left, -1)
    ground = -case.ct * forwards[..., None] * along - case.cn * sideways[..., None] * left
    acceleration = (ground + force[:, 1:] - force[:, :-1]) / m
    couple = half * np.sum(left * (force[:, 1:] + force[:, :-1]), -1)
    turning = (couple.sum(1) - inertia * s2.sum()) / (n * inertia)
    torque = np.cumsum(inertia * (turning[:, None] + s2) - couple, 1)[:, :-1]
    dy = np.concatenate(
        [
            velocity.reshape(len(y), -1),
            y[:, -1:],
            acceleration.reshape(len(y), -1),
            turning[:, None],
        ],
        1,
    )
    return dy, -torque * np.diff(s1), np.sum(ground * velocity, (1, 2))


def march(case: Case, y: Array, steps: int, powers: list[Array] | None = None) -> Array:
    """Return the states a period later; `powers` gets the joints' at every step's beginning."""
    h = case.period_s / steps
    for k in range(steps):
        t = k * h
        a, watts, _ = rates(case, t, y)
        if powers is not None:
            powers.append(watts[0])
        b = rates(case, t + h / 2, y + h / 2 * a)[0]
        c = rates(case, t + h / 2, y + h / 2 * b)[0]
        d = rates(case, t + h, y + h * c)[0]
        y = y + h / 6 * (a + 2 * b + 2 * c + d)
    return y


def reduced(case: Case, y: Array) -> Array:
    """Return states as link 1 sees them: the others' places, all velocities, its rate."""
    n = case.links
    c, s = np.cos(y[:, 2 * n]), np.sin(y[:, 2 * n])
    turn = np.stack([np.stack([c, s], -1), np.stack([-s, c], -1)], 1)
    place, velocity = y[:, : 2 * n].reshape(-1, n, 2), y[:, 2 * n + 1 : -1].reshape(-1, n, 2)
    others = np.einsum("bij,bnj->bni", turn, place[:, 1:] - place[:, :1])
    velocity = np.einsum("bij,bnj->bni", turn, velocity)
    return np.concatenate([others.reshape(len(y), -1), velocity.reshape(len(y), -1), y[:, -1:]], 1)


def whole(case: Case, z: Array) -> Array:
    """Return states with link 1 at the origin, heading 0, of reduced ones (batch, 4n - 1)."""
    n = case.links
    return np.concatenate(
        [np.zeros((len(z), 2)), z[:, : 2 * n - 2], np.zeros((len(z), 1)), z[:, 2 * n - 2 :]], 1
    )


def rest(case: Case) -> Array:
    """Return the reduced state of closed joints in which link 1 rests, (4n - 1,)."""
    s, s1, _ = case.joints(0.0)
    along = np.stack([np.cos(s), np.sin(s)], -1)
    swing = s1[:, None] * np.stack([-along[:, 1], along[:, 0]], -1)
    path = [np.zeros((case.links, 2)) for _ in range(2)]
    for to, of in zip(path, (along, swing), strict=True):
        to[1:] = case.half_m * np.cumsum(of[1:] + of[:-1], 0)
    return np.concatenate([path[0][1:].ravel(), path[1].ravel(), [0.0]])


@dataclass(frozen=True)
class Periodic:
    """Hold a periodic state: means over the period, and the largest multiplier's size."""

    speed_m_s: float
    power_w: float
    abs_power_w: float
    positive_power_w: float
    multiplier: float


def scales(case: Case) -> Array:
    """Return what counts as much of each part of a reduced state."""
    size = np.full(4 * case.links - 1, case.half_m)
    size[2 * case.links - 2 :] *= case.omega_rad_s
    size[-1] = case.omega_rad_s
    return size


def derivative(case: Case, steps: int, z: Array) -> Array:
    """Return the derivative of the period map at z, by differences from both sides."""
    size = scales(case)
    batch = np.vstack([z + 1e-6 * np.diag(size), z - 1e-6 * np.diag(size)])
    ends = reduced(case, march(case, whole(case, batch), steps))
    return ((ends[: len(z)] - ends[len(z) :]) / 2e-6 / size[:, None]).T


def shoot(case: Case, steps: int, z: Array, jacobian: Array | None) -> tuple[Array, Array]:
    """Return where the periodic state of equal steps begins, and the derivative used last.

    A derivative that is given (of other steps) is kept: it only guides the way.
    """
    given = jacobian is not None
    for _ in range(60):
        if not given:
            jacobian = derivative(case, steps, z)
        assert jacobian is not None
        end = reduced(case, march(case, whole(case, z[None]), steps))[0]
        change = np.linalg.solve(np.eye(len(z)) - jacobian, end - z)
        far = float(np.abs(change / scales(case)).max())
        z = z + change * min(1.0, 0.5 / far)
        if far < 1e-10:
            return z, jacobian
        given = given or far < 1e-3
    raise RuntimeError(f"no periodic state of {case}: the last change is {far}")


def means(case: Case, steps: int, z: Array) -> Array:
    """Return speed and the mean net, absolute and positive power of the period from a state."""
    watts: list[Array] = []
    start = whole(case, z[None])
    end = march(case, start, steps, watts)
    travel = (end - start)[0, : 2 * case.links].reshape(-1, 2).mean(0)
    p = np.array(watts)
    sums = [x.sum(1).mean() for x in (p, np.abs(p), np.maximum(p, 0))]
    return np.array([np.hypot(*travel) / case.period_s, *sums])


def solve(case: Case, close: float = 1e-7) -> tuple[Periodic, float, float]:
    """Return the periodic state, and how far twice the steps moved speed and powers, relative.

    Both are extrapolated: orders four, and two where powers have kinks.
    """
    softest = 2 * math.pi / (2.3 * math.sqrt(4 * case.stiffness_n_m / case.mass_kg))
    drag = case.mass_kg / (4 * case.damping_n_s_m + case.cn)
    steps = 2 * math.ceil(case.period_s / min(case.period_s / 300, softest / 8, drag) / 2)
    z, jacobian = shoot(case, steps, rest(case), None)
    multiplier = float(np.abs(np.linalg.eigvals(jacobian)).max())
    before = means(case, steps, z)
    for _ in range(6):
        steps *= 2
        z, _ = shoot(case, steps, z, jacobian)
        found = means(case, steps, z)
        gain = (found - before) / np.array([15, 15, 3, 3])
        off = np.abs(gain) / np.array([found[0], *[found[2]] * 3])
        if off[0] < close and off[1:].max() < 10 * close:
            best = (float(v) for v in found + gain)
            return Periodic(*best, multiplier), float(off[0]), float(off[1:].max())
        before = found
    raise RuntimeError(f"steps of {case} do not agree: {off}")


def draw(rng: np.random.Generator, most: int) -> Case:
    """Return a random robot of 2 to `most` links, springs soft (resonances) to stiff."""

    def log(low: float, high: float) -> float:
        return float(low * (high / low) ** rng.random())

    links, mass, omega = int(rng.integers(2, most + 1)), log(0.03, 1), log(1, 15)
    cn = mass * omega * log(0.3, 10)
    stiffness = mass * omega**2 * log(30, 1e4)  # the softest modes: pi / n sqrt(k/m), about
    damping = math.sqrt(stiffness * mass) * log(0.01, 0.5)
    return Case(
        links,
        mass,
        log(0.02, 0.1),
        cn * log(0.01, 0.5),
        cn,
        rng.uniform(0.2, 1.0),
        rng.uniform(0.5, 1.8),
        omega,
        stiffness,
        damping,
    )


def main() -> None:
    """Write the table, a line of progress per robot."""
    rng = np.random.default_rng(7)
    names = [f.name for f in (*fields(Case), *fields(Periodic))]
    with FILE.open("w", newline="") as file:
        writer = csv.DictWriter(
            file, [*names, "steps_error", "power_steps_error"], lineterminator="\n"
        )
        writer.writeheader()
        for _ in range(8):
            case = draw(rng, 12)
            found, off, power_off = solve(case)
            row = asdict(case) | {k: f"{v:.10g}" for k, v in asdict(found).items()}
            errors = {"steps_error": f"{off:.1e}", "power_steps_error": f"{power_off:.1e}"}
            writer.writerow(row | errors)
            file.flush()
            print(case.links, found, off, power_off, file=sys.stderr)


if __name__ == "__main__":
    main()
