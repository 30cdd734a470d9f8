"""Time periodic states: against a run in time, the paper's grid, n, and the error asked for.

python studies/steady_cost.py OUT       some minutes
"""

from __future__ import annotations

import csv
import math
import statistics
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import serpenoid as sn

PAPER, VISCOUS = sn.Robot(6, 1.0, 0.12), sn.Ground(0.1, 10.0)
OF_2005 = sn.Robot(6, 0.0756, 0.076)
BINGHAM = sn.Ground.whole_body(6, 0.084, 1.2, 0.14, 0.27)
CASES = {"viscous": (PAPER, VISCOUS), "dry": (OF_2005, BINGHAM)}
LINKS = (3, 6, 12, 25, 50, 100)
RTOLS = {
    "viscous": (1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12),
    "dry": (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7),
}
GRID_RTOL = {"viscous": 1e-6, "dry": 1e-4}


@dataclass(frozen=True, slots=True)
class Cost:
    """Hold what one kind of gait costs: seconds of processor time for each, and how many."""

    what: str  # "grid", "gait", "run", "links" or "error"
    ground: str  # "viscous" or "dry"
    links: int
    rtol: float
    error: float  # of the speed, relative, against a much finer one; nan where not asked
    seconds: float  # a gait


def processor_s(work: Callable[[], object], runs: int) -> float:
    """Return the median processor time of a call, s, after one that does not count.

    Processor time, as others may share the machine; the median, as neither the first call (cold
    caches) nor the luckiest is what a user has.
    """
    work()
    times = []
    for _ in range(runs):
        start = time.process_time()
        work()
        times.append(time.process_time() - start)
    return statistics.median(times)


def _gaits(links: int) -> list[sn.Gait]:
    """Return four gaits with about one wave along the body, whose links swing equally far.

    A joint's amplitude shrinks with the links, or a long chain would roll up.
    """
    lag = min(math.radians(80), 2 * math.pi / links)
    alpha = 2 * math.sin(lag / 2)  # links swing by alpha / (2 sin(lag / 2))
    return [sn.Gait(a * alpha, lag, w) for a in (0.4, 0.9) for w in (2.0, 7.0)]


def grid(ground: str) -> sn.Sweep:
    """Solve the paper's 4500 gaits with all powers."""
    robot, friction = CASES[ground]
    return sn.sweep(
        robot,
        friction,
        alpha_rad=np.radians(np.arange(5, 76, 5)),
        beta_rad=np.radians(np.arange(20, 91, 5)),
        omega_rad_s=np.arange(1.0, 21.0),
        rtol=GRID_RTOL[ground],
        threads=1,
    )


def _grid_cost(ground: str) -> Cost:
    count = grid(ground).speed_m_s.size
    taken = processor_s(lambda: grid(ground), 25 if ground == "viscous" else 1)
    return Cost("grid", ground, 6, GRID_RTOL[ground], math.nan, taken / count)


def _run_cost(ground: str) -> Cost:
    """Return what following one gait in time costs until its start is forgotten to 1e-3."""
    robot, friction = CASES[ground]
    gait = sn.Gait(math.radians(70), math.radians(75), 5.0)
    cycles = math.ceil(7 * sn.steady_gait(robot, friction, gait).settling_time_s / gait.period_s)
    scene = sn.Scene(
        robot,
        friction,
        gait,
        method="nonsmooth" if ground == "dry" else "rk4",
        start="zero_momentum",
        dt_s=gait.period_s / 300,
        duration_s=(cycles + 1) * gait.period_s,
        record_every=300,
    )
    return Cost("run", ground, 6, 1e-3, math.nan, processor_s(lambda: sn.simulate(scene), 3))


def _error_cost(ground: str, rtol: float) -> Cost:
    """Return cost and true error of four gaits at an accuracy."""
    robot, friction = CASES[ground]
    errors = []
    for gait in _gaits(6):
        fine = sn.steady_gait(robot, friction, gait, rtol=RTOLS[ground][-1]).speed_m_s
        rough = sn.steady_gait(robot, friction, gait, rtol=rtol).speed_m_s
        errors.append(abs(rough / fine - 1))
    return Cost("error", ground, 6, rtol, max(errors), _solve_s(ground, 6, rtol))


def _solve_s(ground: str, links: int, rtol: float) -> float:
    robot = sn.Robot(links, CASES[ground][0].link_mass_kg, CASES[ground][0].link_length_m)
    friction, gaits = CASES[ground][1], _gaits(links)

    def solve() -> None:
        for gait in gaits:
            sn.steady_gait(robot, friction, gait, rtol=rtol)

    return processor_s(solve, 5) / len(gaits)


def measure() -> list[Cost]:
    """Measure everything, in one process and one thread."""
    rows = []
    for ground in CASES:
        rows += [_grid_cost(ground), _run_cost(ground)]
        rows.append(Cost("gait", ground, 6, 1e-8, math.nan, alone_s(ground)))
        rows += [
            Cost(
                "links",
                ground,
                n,
                GRID_RTOL[ground],
                math.nan,
                _solve_s(ground, n, GRID_RTOL[ground]),
            )
            for n in LINKS
        ]
        rows += [_error_cost(ground, rtol) for rtol in RTOLS[ground]]
    return rows


def alone_s(ground: str) -> float:
    """Return what one steady_gait for the speed alone costs, from Python; the gait is at hand."""
    robot, friction = CASES[ground]
    gait, rtol = (
        sn.Gait(math.radians(30), math.radians(80), 5.0),
        1e-8 if ground == "viscous" else 1e-6,
    )
    return (
        processor_s(
            lambda: [
                sn.steady_gait(robot, friction, gait, rtol=rtol, powers=False) for _ in range(50)
            ],
            41,
        )
        / 50
    )


def summary(rows: list[Cost]) -> list[str]:
    """Return a line for each kind, ratios within this one run."""
    lines = []
    for ground in CASES:
        own = [r for r in rows if r.ground == ground]
        cost = {r.what: r.seconds for r in own if r.what in ("grid", "run", "gait")}
        each = cost["grid"]
        lines += [
            f"{ground}: the paper's grid at {GRID_RTOL[ground]:g}, all powers: {each * 1e6:.3g} us "
            f"a gait, {4500 * each:.3f} s for 4500 on one core",
            f"{ground}: one gait alone, for the speed: {cost['gait'] * 1e6:.0f} us; a run in time "
            f"until the start is forgotten takes {cost['run'] / each:.0f} times a grid's gait",
        ]
    return lines


def write(rows: list[Cost], folder: Path) -> None:
    """Write steady.csv."""
    folder.mkdir(parents=True, exist_ok=True)
    names = ("what", "ground", "links", "rtol", "error", "seconds")
    with (folder / "steady.csv").open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow([*names[:-1], "seconds_per_gait"])
        writer.writerows([getattr(row, name) for name in names] for row in rows)


if __name__ == "__main__":
    costs = measure()
    write(costs, Path(sys.argv[1]))
    print(*summary(costs), sep="\n")
