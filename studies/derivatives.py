"""Hold derivatives of periodic states to differences of tight solutions, at kinks to both sides."""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import serpenoid as sn
from numpy.typing import NDArray
from serpenoid import _core
from serpenoid.model.core_model import core_model
from serpenoid.periodic.sensitivities import QUANTITIES, Parts, differentiate, parameters

Array = NDArray[np.float64]
KINDS = ("viscous", "dry", "ratchet")
TIGHT = {"viscous": 1e-12, "dry": 1e-9, "ratchet": 1e-9}
STEPS = 2.0 ** -np.arange(2, 9)  # over the step of a parameter: one-sided differences


def drawn(rng: np.random.Generator, kind: str) -> Parts:
    """Return a random state: a bend in two of five, joints of their own in half."""

    def log(low: float, high: float) -> float:
        return float(low * (high / low) ** rng.random())

    links, mass, omega = int(rng.integers(3, 9)), log(0.02, 1), log(0.5, 12)
    cn = mass * omega * log(0.1, 20)
    ct, fn0 = cn * log(0.01, 0.3), 9.81 * mass * log(0.02, 0.5) * (kind != "viscous")
    ft0 = fn0 * log(0.02, 0.5)
    ground = sn.Ground(ct, cn, ft0, fn0)
    if kind == "ratchet":
        ground = sn.Ground((ct, ct * log(1.5, 20)), cn, (ft0, ft0 * log(1.5, 20)), fn0)
    gait = sn.Gait(rng.uniform(0.3, 1.3), rng.uniform(0.6, 2.2), omega)
    if rng.random() < 0.4:
        gait = sn.Gait(gait.alpha_rad, gait.beta_rad, omega, rng.uniform(-0.3, 0.3))
    if rng.random() < 0.5:
        gain, shift = rng.uniform(0.8, 1.2, links - 1), rng.normal(0, 0.1, links - 1)
        gait = sn.Gait(
            gait.alpha_rad,
            gait.beta_rad,
            omega,
            gait.offset_rad,
            tuple(gain.tolist()),
            tuple(shift.tolist()),
        )
    return sn.Robot(links, mass, log(0.03, 0.2)), ground, gait


def tight(parts: list[Parts], kind: str) -> Array:
    """Return speed, powers and turn of states near the first one, (N, Q), NaN where not found."""
    models = [core_model(*each) for each in parts]
    states = _core.neighbours(models[0], models, TIGHT[kind], True, 1)
    return np.array(
        [
            [s.speed, s.power, s.positive_power, s.turn]
            if s.speed_error < 1e-6 * s.speed + 1e-9
            else [np.nan] * 4
            for s in states
        ]
    )


@dataclass
class Count:
    """Count derivatives held, and those outside what was told."""

    held: Counter[str] = field(default_factory=Counter)
    off: list[str] = field(default_factory=list)

    def hold(self, name: str, told: Array, room: Array, truth: Array, where: str) -> None:
        """Hold the told values of all quantities to true ones; NaN in truth is left out."""
        known = np.isfinite(truth) & np.isfinite(told)
        self.held[name] += int(known.sum())
        for q in np.flatnonzero(known & (abs(told - truth) > room)):
            self.off.append(
                f"{name} {QUANTITIES[q]} {where}: told {told[q]:.6g}, room {room[q]:.2g}, "
                f"is {truth[q]:.6g}"
            )


def one_sided(
    parts: Parts, move: Callable[[float], Parts], value: float, step: float, kind: str
) -> tuple[Array, Array]:
    """Return derivatives to both sides, (2, Q), and their doubts.

    Beside a kink a difference over h is off by the root of h where a wheel rests for a moment, by h
    elsewhere, and by 1/h as the kink is not quite here: all are fitted and taken off.
    """
    h = step * STEPS
    states = tight([parts, *(move(value + sign * each) for sign in (-1, 1) for each in h)], kind)
    slopes = (states[1:].reshape(2, len(h), -1) - states[0]) / h[:, None]
    slopes[0] *= -1
    basis = np.column_stack([np.ones(len(h)), np.sqrt(STEPS), STEPS, 0.01 / STEPS])
    fit = np.linalg.pinv(basis)
    found = np.einsum("k,skq->sq", fit[0], slopes)
    missed = slopes - np.einsum("jk,kl,slq->sjq", basis, fit, slopes)
    noise = abs(fit[0] / h).sum() * TIGHT[kind] * abs(states[0])
    return found, 10 * abs(missed).max(axis=1) + noise


def hold_random(kind: str, seed: int, count: int, total: Count) -> None:
    """Hold all derivatives of random states to central differences of tight solutions."""
    for k in range(count):
        parts = drawn(np.random.default_rng([seed, k]), kind)
        try:
            told = differentiate(*parts)
        except sn.NotConverged:
            total.held["no state"] += 1
            continue
        by_name = {p.name: p for p in parameters(*parts)}
        for i, name in enumerate(told.names):
            p = by_name[name]
            h = p.step / 8
            around = tight([parts] + [p.moved(p.value + j * h) for j in (-2, -1, 1, 2)], kind)
            near, far = (around[3] - around[2]) / (2 * h), (around[4] - around[1]) / (4 * h)
            truth = (4 * near - far) / 3
            noise = 20 * TIGHT[kind] * abs(around[0]) / h + 1e-12
            jump = abs(around[3] + around[2] - 2 * around[0]) / h
            smooth = jump <= 2e-3 * abs(truth) + 4 * noise
            truth[~smooth] = np.nan
            total.held["left out"] += int((~smooth).sum())
            room = told.errors[i] + noise + abs(near - far) / 10
            where = f"{kind} {seed} {k} {name}{' (kink)' if told.kinks[i] else ''}"
            total.hold(kind, told.derivatives[i], room, truth, where)


def grazing(parts: Parts, name: str, kind: str) -> float | None:
    """Return a value of a parameter at which a wheel's mode just changes, or None.

    The widest second difference of the speed is where a slope changes; it is closed in on.
    """
    p = next(p for p in parameters(*parts) if p.name == name)
    low, high, points = p.value - 80 * p.step, p.value + 80 * p.step, 129
    for _ in range(7):
        grid = np.linspace(low, high, points)
        speed = tight([p.moved(v) for v in grid.tolist()], kind)[:, 0]
        bends = abs(np.diff(speed, 2))
        if not np.isfinite(bends).all():
            return None
        k = int(bends.argmax())
        if bends[k] < 6 * np.median(bends) or k in (0, len(bends) - 1):
            return None
        low, high, points = grid[k], grid[k + 2], 9
    return float((low + high) / 2)


def hold_grazing(kind: str, seed: int, count: int, total: Count) -> None:
    """Hold both sides of derivatives to one-sided differences at states where a mode changes."""
    for k in range(count):
        rng = np.random.default_rng([seed, k])
        parts = drawn(rng, kind)
        name = ("omega_rad_s", "alpha_rad", "fn0", "beta_rad")[int(rng.integers(4))]
        try:
            at = grazing(parts, name, kind)
            if at is None:
                continue
            parts = next(p for p in parameters(*parts) if p.name == name).moved(at)
            told = differentiate(*parts)
        except (sn.NotConverged, sn.BadInput):
            total.held["no state"] += 1
            continue
        total.held["grazing states"] += 1
        by_name = {p.name: p for p in parameters(*parts)}
        for i, each in enumerate(told.names):
            p = by_name[each]
            truth, doubt = one_sided(parts, p.moved, p.value, p.step, kind)
            for side, word in enumerate(("less", "more")):
                room = told.side_errors[i, :, side] + doubt[side]
                where = f"{kind} {seed} {k} {name}: {each}{' (kink)' if told.kinks[i] else ''}"
                total.hold(f"{kind} {word}", told.sides[i, :, side], room, truth[side], where)
            jump, noise = abs(truth[1] - truth[0]), doubt.sum(axis=0)
            sure = jump > 0.05 * abs(truth).max(axis=0) + 2 * noise
            total.held["true kinks"] += int(sure.any())
            if sure.any() and not told.kinks[i]:
                total.off.append(f"kink not told: {kind} {seed} {k} {name}: {each}")


def main() -> None:
    """Count what is outside of what is told."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("what", choices=["random", "grazing"])
    parser.add_argument("--count", type=int, default=500, help="states to draw of each kind")
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    hold = hold_random if given.what == "random" else hold_grazing
    for kind in KINDS if given.what == "random" else KINDS[1:]:
        total = Count()
        for k in range(0, given.count, 20):
            hold(kind, given.seed * 1000 + k, min(20, given.count - k), total)
            print(kind, k + 20, dict(total.held), "off:", len(total.off), flush=True)
        print(*total.off, sep="\n", flush=True)


if __name__ == "__main__":
    main()
