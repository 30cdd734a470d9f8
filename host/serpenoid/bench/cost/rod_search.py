"""The fastest gait at a rate, searched as PyElastica's continuum snake does, and by ours.

That example gives muscle torques (six coefficients of a spline and a wave length) to CMA-ES, which
simulates the rod anew for each, for most forward speed at a fixed period. Here CMA-ES varies what a
gait of this robot has: amplitude and lag of the joints. Each gait tried is followed from rest until
it repeats, and written down at once: a search that was interrupted goes on, because the same seed
asks for the same gaits. Beside it: the same CMA-ES over the exact model's periodic states, and a
grid of them made finer around its best.
"""

from __future__ import annotations

import csv
import math
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass, fields
from pathlib import Path

import numpy as np

import serpenoid as sn

from ...model.errors import NotConverged
from ..peers.rod_robot import as_rod_sees_it
from .rod import SETTLED, STEP_S
from .rod_log import Log, Tried
from .steady import PAPER, VISCOUS

RATE_RAD_S = 5.0
LOW_RAD, HIGH_RAD = (0.05, 0.1), (2.0, 2.8)  # of alpha and beta
START_RAD, SIGMA_RAD = (0.8, 1.05), 0.3  # one wave along the body
ENOUGH = {"tolx": 1e-3, "tolfun": 1e-4}  # rad and m/s: where CMA-ES ends by itself
GENERATION = 6  # gaits, as CMA-ES has them for two variables
MOST_OFF_RAD = 0.2  # a rod further off its gait has burst: no speed of it counts
POINTS, ZOOMS = 16, 4
NOT_STATED = (
    "rigid links on pins (its elements bend into each other over a stiff joint)",
    "a link's own inertia, as mass sits at the nodes (the exact model here takes the rod's)",
    "wheels that stick, ratchets, joint limits, servos, faults, slopes",
    "its example's own drive by muscle torques, where joint angles are given",
)
Speed = Callable[[sn.Gait], float]
Follow = Callable[[int, sn.Gait], Tried]


@dataclass(frozen=True, slots=True)
class Searched:
    """Hold what a way of searching found: the gait, how many it solved, processor time in s.

    rod_m_s: of that gait, followed by the rod; exact_m_s: by the exact model with its inertia.
    ended: by itself, not because its runs were used up.
    """

    way: str
    gaits: int
    seconds: float
    alpha_rad: float
    beta_rad: float
    rod_m_s: float
    exact_m_s: float
    ended: bool

    @property
    def each_s(self) -> float:
        """Return the processor time of one gait, s."""
        return self.seconds / self.gaits


def exact_speed(gait: sn.Gait) -> float:
    """Return a gait's speed by the exact model with the rod's inertia, m/s."""
    try:
        return sn.steady_gait(as_rod_sees_it(PAPER), VISCOUS, gait, powers=False).speed_m_s
    except NotConverged:
        return math.nan


def cma_es(speed: Speed, omega_rad_s: float, runs: int, seed: int) -> tuple[sn.Gait, int, bool]:
    """Return the fastest gait that CMA-ES found, how many it tried, and whether it was done."""
    import cma  # pyright: ignore[reportMissingImports] (an optional extra)

    found: list[tuple[float, sn.Gait]] = []

    def cost(at: np.ndarray) -> float:
        gait = sn.Gait(float(at[0]), float(at[1]), omega_rad_s)
        value = -speed(gait)
        value = 1.0 if math.isnan(value) else value  # worse than any gait: none goes backwards
        found.append((value, gait))
        return value

    search = cma.CMAEvolutionStrategy(list(START_RAD), SIGMA_RAD, {
        "bounds": [list(LOW_RAD), list(HIGH_RAD)], "seed": seed, "popsize": GENERATION,
        "verbose": -9, **ENOUGH,
    })  # fmt: skip
    while not search.stop() and len(found) + GENERATION <= max(runs, GENERATION):
        asked = search.ask()
        search.tell(asked, [cost(np.asarray(at)) for at in asked])
    return min(found, key=lambda f: f[0])[1], len(found), bool(search.stop())


def zoomed_grid(omega_rad_s: float) -> tuple[sn.Gait, int]:
    """Return the fastest gait of a grid over all that is searched, made finer around its best."""
    robot, count = as_rod_sees_it(PAPER), 0
    low, high = np.array(LOW_RAD), np.array(HIGH_RAD)
    best = np.array(START_RAD)
    for _ in range(ZOOMS):
        alpha, beta = (np.linspace(a, b, POINTS) for a, b in zip(low, high, strict=True))
        found = sn.sweep(robot, VISCOUS, alpha_rad=alpha, beta_rad=beta, threads=1,
                         omega_rad_s=[omega_rad_s], powers=False)  # fmt: skip
        speed = found.speed_m_s[:, :, 0]
        at = np.unravel_index(np.nanargmax(speed), speed.shape)
        best, count = np.array([alpha[at[0]], beta[at[1]]]), count + speed.size
        step = 2 * (high - low) / (POINTS - 1)
        low, high = np.maximum(best - step, LOW_RAD), np.minimum(best + step, HIGH_RAD)
    return sn.Gait(float(best[0]), float(best[1]), omega_rad_s), count


def followed(number: int, gait: sn.Gait) -> Tried:
    """Return a gait as PyElastica's rod follows it."""
    from ..peers.elastica_peer import follow

    rod = follow(PAPER, VISCOUS, gait, STEP_S, SETTLED)
    speed = rod.speed_m_s if rod.bend_error_rad < MOST_OFF_RAD else math.nan
    return Tried(number, gait.omega_rad_s, gait.alpha_rad, gait.beta_rad, speed, rod.cycles,
                 rod.bend_error_rad, rod.seconds)  # fmt: skip


def by_rod(
    path: Path, runs: int, seed: int, omega_rad_s: float, tell: Callable[[str], object],
    follow: Follow = followed,
) -> Searched:  # fmt: skip
    """Search by a rod; every gait it follows is kept in the file. Raises BadInput."""
    path.parent.mkdir(parents=True, exist_ok=True)
    log = Log(path, follow)
    used: list[Tried] = []

    def speed(gait: sn.Gait) -> float:
        row, before = log.tried(gait)
        used.append(row)
        best = max((t.speed_m_s for t in used if t.speed_m_s > 0), default=math.nan)
        spent = "from the file" if before else f"{row.seconds:.1f} s"
        tell(f"run {row.number} of at most {runs}: {row.told} ({spent}); best {best:.4f} m/s")
        return row.speed_m_s

    gait, count, done = cma_es(speed, omega_rad_s, runs, seed)
    best = max(t.speed_m_s for t in used if t.speed_m_s > 0)
    return Searched("PyElastica, CMA-ES", count, sum(t.seconds for t in used), gait.alpha_rad,
                    gait.beta_rad, best, exact_speed(gait), done)  # fmt: skip


def search(
    path: Path, runs: int, seed: int, tell: Callable[[str], object],
    omega_rad_s: float = RATE_RAD_S, follow: Follow = followed,
) -> list[Searched]:  # fmt: skip
    """Search by a rod, by the same CMA-ES over the exact model, and by a grid of it."""
    rod = by_rod(path, runs, seed, omega_rad_s, tell, follow)
    tell("the exact model's searches; their gaits, too, are followed once by the rod")
    return [rod, *_exact_ways(omega_rad_s, runs, seed, follow)]


def _exact_ways(omega_rad_s: float, runs: int, seed: int, follow: Follow) -> list[Searched]:
    spent = 0.0

    def timed(gait: sn.Gait) -> float:
        nonlocal spent
        start = time.process_time()
        speed = exact_speed(gait)
        spent += time.process_time() - start
        return speed

    exact_speed(sn.Gait(*START_RAD, omega_rad_s))
    same, count, done = cma_es(timed, omega_rad_s, runs, seed)
    zoomed_grid(omega_rad_s)
    start = time.process_time()
    gridded, gaits = zoomed_grid(omega_rad_s)
    taken = time.process_time() - start
    ways = (("ours, the same CMA-ES", same, count, spent, done),
            ("ours, a grid made finer", gridded, gaits, taken, True))  # fmt: skip
    return [
        Searched(way, many, seconds, gait.alpha_rad, gait.beta_rad,
                 follow(0, gait).speed_m_s, exact_speed(gait), ended)
        for way, gait, many, seconds, ended in ways
    ]  # fmt: skip


def summary(found: list[Searched]) -> list[str]:
    """Return what a rod's search costs beside the exact model's, and how far they are apart."""
    rod, same, grid = found
    apart = (
        math.degrees(abs(rod.alpha_rad - grid.alpha_rad)),
        math.degrees(abs(rod.beta_rad - grid.beta_rad)),
    )
    lines = [
        f"a gait followed by the rod takes {rod.each_s / same.each_s:.2g} times the processor time "
        "of the exact model's periodic state",
        f"the rod's search takes {rod.seconds / grid.seconds:.2g} times that of the exact model "
        f"over {grid.gaits} gaits of the whole range",
        f"their gaits are {apart[0]:.1f} deg in alpha and {apart[1]:.1f} deg in beta apart; the "
        f"rod's is {100 * (1 - rod.exact_m_s / grid.exact_m_s):.2g} % slower in the exact model, "
        f"the exact model's {100 * (grid.rod_m_s / rod.rod_m_s - 1):+.2g} % in the rod",
    ]
    if not rod.ended:
        lines.append("the rod's search was not done: more runs go on with it")
    return lines


def write(found: list[Searched], path: Path) -> None:
    """Write what each way found as CSV."""
    with path.open("w", newline="") as file:
        writer = csv.DictWriter(file, [f.name for f in fields(Searched)])
        writer.writeheader()
        writer.writerows(asdict(row) for row in found)
