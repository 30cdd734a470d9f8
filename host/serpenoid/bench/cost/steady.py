"""Time the periodic-state solver: one gait, the paper's grid, a gait with sticking wheels."""

from __future__ import annotations

import math
import platform
import statistics
import time
from collections.abc import Callable

import numpy as np

import serpenoid as sn

PAPER, VISCOUS = sn.Robot(6, 1.0, 0.12), sn.Ground(0.1, 10.0)
OF_2005 = sn.Robot(6, 0.0756, 0.076)
BINGHAM = sn.Ground.whole_body(6, 0.084, 1.2, 0.14, 0.27)
PAPERS_GAIT = sn.Gait(math.radians(30), math.radians(80), 5.0)
GAIT_2005 = sn.Gait(math.radians(70), math.radians(75), 5.0)


def median_s(work: Callable[[], object], runs: int) -> float:
    """Return the median time of a call, s, after one that does not count."""
    work()
    times = []
    for _ in range(runs):
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return statistics.median(times)


def grid() -> sn.Sweep:
    """Solve the paper's 4500 gaits with all powers."""
    return sn.sweep(
        PAPER, VISCOUS, alpha_rad=np.radians(np.arange(5, 76, 5)),
        beta_rad=np.radians(np.arange(20, 91, 5)), omega_rad_s=np.arange(1.0, 21.0),
    )  # fmt: skip


def main() -> None:
    """Print one line a case: median time of one core, and the error that goes with it."""
    print(f"{platform.processor() or platform.machine()}, Python {platform.python_version()}")
    for rtol in (1e-4, 1e-6, 1e-8):
        took = median_s(lambda r=rtol: sn.steady_gait(PAPER, VISCOUS, PAPERS_GAIT, rtol=r), 300)
        print(f"six links, viscous, rtol {rtol:.0e}: {took * 1e6:7.0f} us a gait, all powers")
    for rtol in (1e-4, 1e-6):
        took = median_s(lambda r=rtol: sn.steady_gait(OF_2005, BINGHAM, GAIT_2005, rtol=r), 20)
        print(f"2005 robot, sticking wheels, rtol {rtol:.0e}: {took * 1e3:5.1f} ms a gait")
    took = median_s(grid, 5)
    print(
        f"the paper's grid of 4500 gaits, rtol 1e-06: {took:.3f} s, {took / 4500 * 1e6:.0f} us each"
    )


if __name__ == "__main__":
    main()
