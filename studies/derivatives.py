"""Hold derivatives of random periodic states to differences of tight solutions."""

from __future__ import annotations

import argparse
from collections import Counter
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


def main() -> None:
    """Count what is outside of what is told."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=500, help="states to draw of each kind")
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    for kind in KINDS:
        total = Count()
        for k in range(0, given.count, 20):
            hold_random(kind, given.seed * 1000 + k, min(20, given.count - k), total)
            print(kind, k + 20, dict(total.held), "off:", len(total.off), flush=True)
        print(*total.off, sep="\n", flush=True)


if __name__ == "__main__":
    main()
