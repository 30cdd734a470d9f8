"""Compare the implicit model's RK4 kernel with a hand-written Numba one, and with its floor.

python studies/kernels.py        half a minute; needs Numba (`pip install 'serpenoid[bench]'`)
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # the machine's peak is that of one core

import platform
import statistics
import time
from collections.abc import Callable

import numpy as np
from serpenoid import _core
from serpenoid.bench.peers import numba_equations as q
from serpenoid.bench.problems import Problem, problems
from serpenoid.simulation.core_run import core_request

DT_S, ROUNDS = 1e-3, 201
# Operations of a step of rk4_kernel.hpp for every row of links: load() and finish() four times,
# stages(), shape() twice. And once: sincos() six times, sums, link 1.
ROW = {"fma": 4 * 9 + 18 + 2 * 20, "mul": 4 * 17 + 2 * 5, "add": 4 * 20 + 10 + 2 * 1}
ONCE = {"fma": 6 * 17 + 11, "mul": 6 * 3 + 17, "add": 6 * 1 + 8}


def operations(links: int) -> int:
    """Return the floating-point operations of a step; a fused multiply-add counts two."""
    sums = {sort: links * ROW[sort] + ONCE[sort] for sort in ROW}
    return 2 * sums["fma"] + sums["mul"] + sums["add"]


def interleaved_s(works: dict[str, Callable[[], object]], rounds: int) -> dict[str, float]:
    """Return the median time of every call, s; each round runs all of them once.

    The time is that of this thread on the processor: other work of a busy machine does not count.
    """
    times: dict[str, list[float]] = {name: [] for name in works}
    for _ in range(rounds + 1):
        for name, work in works.items():
            start = time.thread_time()
            work()
            times[name].append(time.thread_time() - start)
    return {name: statistics.median(all_[1:]) for name, all_ in times.items()}


def matrix_product_rate() -> float:
    """Return the operations a second of a matrix product: what one core can do."""
    a = np.ones((384, 384))
    return 2 * 384**3 / interleaved_s({"": lambda: a @ a}, 41)[""]


def show(problem: Problem) -> None:
    """Print the time of a step for both, and the floor."""
    links = problem.robot.links
    steps = 6000 // links
    scene = problem.scene(
        method="rk4", dt_s=DT_S, duration_s=steps * DT_S, record_every=steps, start=problem.start
    )
    request, start, p = core_request(scene), problem.start.packed(), q.parameters(problem)
    took = interleaved_s(
        {
            "Numba RK4": lambda: q.rk4(True, problem.first, p, DT_S, steps),
            "serpenoid RK4": lambda: _core.run(request, start, None),
        },
        ROUNDS,
    )
    print(f"\n{problem.title}; per step, medians of {ROUNDS} interleaved rounds")
    for name, one_s in took.items():
        print(f"  {name:14s} {one_s / steps * 1e9:8.1f} ns  {took['Numba RK4'] / one_s:5.2f} x")
    floor_s = operations(links) / matrix_product_rate()
    print(
        f"  floor {floor_s * 1e9:.1f} ns: {operations(links)} operations at the rate of a matrix "
        "product.\n  A run cannot reach it: each stage waits for the sum over links of the stage "
        "before,\n  and only one operation in three is fused."
    )


def main() -> None:
    """Print the table for the paper's snake, and for a long one."""
    print(
        f"{platform.processor() or platform.machine()}, Python {platform.python_version()}, "
        f"{_core.instruction_sets()[0]}"
    )
    for name in ("paper6_k1e3", "n50_k1e5"):
        show(next(p for p in problems() if p.name == name))


if __name__ == "__main__":
    main()
