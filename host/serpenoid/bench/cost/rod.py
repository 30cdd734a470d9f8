"""Time one gait's speed beside PyElastica, which must follow the gait until it repeats."""

from __future__ import annotations

import csv
import math
from dataclasses import asdict, dataclass
from pathlib import Path

import serpenoid as sn

from ..peers.rod_robot import as_rod_sees_it
from .steady import PAPER, VISCOUS, processor_s

GAITS = {"paper": (30.0, 80.0, 5.0), "slow": (32.0, 84.0, 1.8), "fast": (25.0, 86.0, 10.0)}
STEP_S, SETTLED = 2e-4, 3e-3


@dataclass(frozen=True, slots=True)
class RodRow:
    """Hold one gait: speeds and processor time of both, PyElastica's until it repeats to SETTLED.

    exact_m_s: of the exact model with the inertia that a rod gives to its links.
    """

    gait: str
    rod_m_s: float
    exact_m_s: float
    rod_cycles: int
    rod_change: float
    rod_bend_error_rad: float
    rod_s: float
    exact_s: float

    @property
    def times(self) -> float:
        """Return how many times as long PyElastica took."""
        return self.rod_s / self.exact_s

    @property
    def apart(self) -> float:
        """Return how far the rod's speed is off the exact model's, relative."""
        return self.rod_m_s / self.exact_m_s - 1


def measure(names: list[str], settled: float = SETTLED) -> list[RodRow]:
    """Follow each gait by PyElastica, and solve it by the exact model."""
    from ..peers.elastica_peer import follow

    rows = []
    for name in names:
        alpha, beta, rate = GAITS[name]
        gait = sn.Gait(math.radians(alpha), math.radians(beta), rate)
        seen = as_rod_sees_it(PAPER)
        rod = follow(PAPER, VISCOUS, gait, STEP_S, settled)
        exact = sn.steady_gait(seen, VISCOUS, gait, powers=False).speed_m_s
        taken = processor_s(
            lambda gait=gait, seen=seen: [
                sn.steady_gait(seen, VISCOUS, gait, powers=False) for _ in range(50)
            ],
            3,
        )
        rows.append(
            RodRow(name, rod.speed_m_s, exact, rod.cycles, rod.change, rod.bend_error_rad,
                   rod.seconds, taken / 50)
        )  # fmt: skip
    return rows


def write(rows: list[RodRow], path: Path) -> None:
    """Write the rows as CSV."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w", newline="") as file:
        writer = csv.DictWriter(file, list(asdict(rows[0])))
        writer.writeheader()
        writer.writerows(asdict(row) for row in rows)
