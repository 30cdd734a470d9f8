"""Compare the cost of periodic states with its floor: the least arithmetic, at this core's best.

python studies/floors.py         some two minutes
"""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
import tempfile

import numpy as np
from steady_cost import OF_2005, PAPER, alone_s, grid, processor_s

GAITS = 4500  # of the paper's grid


def product_s() -> float:
    """Return the time of one multiply-add at this core's best, s.

    NumPy's matrix product reaches it (60 wide: larger ones use several threads).
    """
    size, runs = 60, 1000
    a = np.ones((size, size))
    return processor_s(lambda: [a @ a for _ in range(runs)], 9) / size**3 / runs


def viscous_products(powers: bool = True) -> int:
    """Return the multiply-adds of one step of Newton's method, the means and the joints' powers.

    24 nodes. Each joint's power has a kink where its rate changes sign, which weights of the shape
    correct, and one or two where its torque changes sign. In all some 14 000, powers 3500 of them.
    """
    nodes, joints = 24, PAPER.links - 1
    motion = nodes * (6 * nodes + 240) + nodes * (nodes + 40)
    return motion + powers * joints * (16 * nodes + 32 + round(1.5 * 190))


def dry_products() -> int:
    """Return the multiply-adds of following half a cycle once, from the right start.

    A half cycle has 19 pieces between changes of mode (mean of the last pass over the grid at
    1e-4; the solver makes 2.9 passes a gait). Each piece needs one evaluation of its five stages
    and one Newton step, with four right sides for the derivative. It then needs the test whether
    a wheel's mode ends, integrals, joint powers, and the convex step to the next mode: some 7000.
    """
    pieces, stages, links, wheels, joints = 19, 5, OF_2005.links, 2 * OF_2005.links, 5
    shape, sums = 60 * links, 14 * wheels  # of a stage: sines, places, rates; drag and its matrix
    unknowns = 3 * stages
    newton = unknowns**3 // 3 + 4 * unknowns**2
    modes = wheels * (4 * (stages + 1) + (stages + 1) ** 2)  # speeds, bounds of their polynomials
    powers, integrals = joints * (25 * stages + 100), 60 * stages
    change = shape + sums + 150
    return pieces * (stages * (shape + sums) + newton + modes + powers + integrals + change)


def process_s(arguments: list[str]) -> float:
    """Return the processor time of a whole Python process, s, the median of five."""
    times = []
    for _ in range(5):
        before = sum(os.times()[2:4])
        subprocess.run([sys.executable, *arguments], check=True, capture_output=True)
        times.append(sum(os.times()[2:4]) - before)
    return statistics.median(times)


def line(what: str, took_s: float, floor_s: float, floor: str) -> str:
    """Return a line of the table."""
    return (
        f"{what}: {took_s:.3g} s, {took_s / floor_s:.1f} times its floor {floor_s:.3g} s: {floor}"
    )


def main() -> None:
    """Print cost and floor of both grids, of one gait, and of a sweep to a file."""
    each = product_s()
    step = "one Newton step and the powers"
    print(
        line(
            "viscous grid",
            processor_s(lambda: grid("viscous"), 25),
            GAITS * viscous_products() * each,
            step,
        )
    )
    print(
        line(
            "dry grid",
            processor_s(lambda: grid("dry"), 1),
            GAITS * dry_products() * each,
            "following half a cycle once",
        )
    )
    print(
        line(
            "one viscous gait",
            alone_s("viscous"),
            viscous_products(powers=False) * each,
            "one Newton step, as if one of four in a vector",
        )
    )
    with tempfile.TemporaryDirectory() as folder:
        sweep = ["-m", "serpenoid", "sweep", "--robot", "paper", "--threads", "1"]
        took_s = process_s([*sweep, "--out", f"{folder}/grid.csv"])
    print(
        line(
            "viscous grid to a file",
            took_s,
            process_s(["-c", "import numpy"]),
            "a process that imports NumPy",
        )
    )


if __name__ == "__main__":
    main()
