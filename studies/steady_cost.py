"""Time periodic states: the paper's grid, one gait alone, a run in time; and count their floor.

The floor is the least arithmetic, at this core's best.

python studies/steady_cost.py       some two minutes
"""

from __future__ import annotations

import math
import statistics
import time
from collections.abc import Callable

import numpy as np
import serpenoid as sn

PAPER, OF_2005 = sn.Robot(6, 1.0, 0.12), sn.Robot(6, 0.0756, 0.076)
CASES = {
    "viscous": (PAPER, sn.Ground(0.1, 10.0)),
    "dry": (OF_2005, sn.Ground.whole_body(6, 0.084, 1.2, 0.14, 0.27)),
}
GRID_RTOL = {"viscous": 1e-6, "dry": 1e-4}
GAIT_RTOL = {"viscous": 1e-8, "dry": 1e-6}


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


def grid(ground: str) -> sn.Sweep:
    """Solve the paper's 4500 gaits with all powers."""
    return sn.sweep(
        *CASES[ground],
        alpha_rad=np.radians(np.arange(5, 76, 5)),
        beta_rad=np.radians(np.arange(20, 91, 5)),
        omega_rad_s=np.arange(1.0, 21.0),
        rtol=GRID_RTOL[ground],
        threads=1,
    )


def alone_s(ground: str) -> float:
    """Return what one steady_gait for the speed alone costs, from Python; the gait is at hand."""
    robot, friction = CASES[ground]
    gait, rtol = sn.Gait(math.radians(30), math.radians(80), 5.0), GAIT_RTOL[ground]

    def solve() -> None:
        for _ in range(50):
            sn.steady_gait(robot, friction, gait, rtol=rtol, powers=False)

    return processor_s(solve, 41) / 50


def run_s(ground: str) -> float:
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
    return processor_s(lambda: sn.simulate(scene), 3)


def product_s() -> float:
    """Return the time of one multiply-add at this core's best, s.

    NumPy's matrix product reaches it (60 wide: larger ones use several threads).
    """
    size, runs = 60, 1000
    a = np.ones((size, size))
    return processor_s(lambda: [a @ a for _ in range(runs)], 9) / size**3 / runs


def viscous_products() -> int:
    """Return the multiply-adds of one step of Newton's method, the means and the joints' powers.

    24 nodes. Each joint's power has a kink where its rate changes sign, which weights of the shape
    correct, and one or two where its torque changes sign. In all some 14 000, powers 3500 of them.
    """
    nodes, joints = 24, PAPER.links - 1
    motion = nodes * (6 * nodes + 240) + nodes * (nodes + 40)
    return motion + joints * (16 * nodes + 32 + round(1.5 * 190))


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


def main() -> None:
    """Print a line for each ground, ratios within this one run."""
    for ground, products, runs in (("viscous", viscous_products(), 25), ("dry", dry_products(), 1)):
        count = grid(ground).speed_m_s.size
        each = processor_s(lambda ground=ground: grid(ground), runs) / count
        print(
            f"{ground}: {count} gaits at {GRID_RTOL[ground]:g}, all powers: {count * each:.3g} s, "
            f"{each / (products * product_s()):.1f} times the least arithmetic; one gait alone, "
            f"for its speed: {1e6 * alone_s(ground):.0f} us; a run in time until the start is "
            f"forgotten: {run_s(ground) / each:.0f} times a gait of the grid"
        )


if __name__ == "__main__":
    main()
