"""Time the implicit model's RK4 kernels beside a hand-written Numba one, and count their floor."""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # the machine's peak is that of one core

import platform
import statistics
import time
from collections.abc import Callable

import numpy as np

from serpenoid import _core
from serpenoid.bench.peers import numba_equations as q  # needs the extra `bench`
from serpenoid.bench.problems import Problem, problems
from serpenoid.simulation.gait_batch import batch_scene, batch_state, gait_rows

DT_S, ROUNDS = 1e-3, 201
# Operations of rk4_kernel.hpp a step, by sort, for every row of links: load() and finish() four
# times, stages(), shape() twice; and once: sincos() six times, sums, link 1.
ROW = {"fma": 4 * 9 + 18 + 2 * 20, "mul": 4 * 17 + 2 * 5, "add": 4 * 20 + 10 + 2 * 1}
ONCE = {"fma": 6 * 17 + 11, "mul": 6 * 3 + 17, "add": 6 * 1 + 8}
READ, WRITTEN, KEPT = 68, 28, 26  # doubles a link: moved in a step, and the task's own memory


def operations(links: int) -> int:
    """Return floating-point operations a step and gait of a batch; a fused one counts two."""
    sums = {sort: links * ROW[sort] + ONCE[sort] for sort in ROW}
    return 2 * sums["fma"] + sums["mul"] + sums["add"]


def interleaved_s(works: dict[str, Callable[[], object]], rounds: int) -> dict[str, float]:
    """Return the median time of every call, s, each round running all of them once.

    The time is this thread's own on the processor: a busy machine's other work does not count.
    """
    times: dict[str, list[float]] = {name: [] for name in works}
    for _ in range(rounds + 1):
        for name, work in works.items():
            start = time.thread_time()
            work()
            times[name].append(time.thread_time() - start)
    return {name: statistics.median(all_[1:]) for name, all_ in times.items()}


def lanes(
    problem: Problem, kernels: str, batch: bool, count: int, steps: int
) -> Callable[[], object]:
    """Return the call that runs `count` equal gaits, links or gaits side by side."""
    scene, gaits = batch_scene(problem.scene()), gait_rows([problem.gait] * count)
    starts = np.tile(batch_state(problem.start), (count, 1))
    end = steps * DT_S
    return lambda: _core.run_batch(scene, gaits, starts, DT_S, end, steps, kernels, batch)


def contenders(problem: Problem, steps: int) -> dict[str, tuple[Callable[[], object], int]]:
    """Return the calls to time and how many trajectories each runs."""
    p, first = q.parameters(problem), problem.first
    found = {
        "Numba RK4, by hand": (lambda: q.rk4(True, first, p, DT_S, steps), 1),
    }
    for kernels in _core.instruction_sets():
        found[f"{kernels}, one run"] = (lanes(problem, kernels, False, 1, steps), 1)
        found[f"{kernels}, batch"] = (lanes(problem, kernels, True, 4, steps), 4)
    return found


def matrix_product_rate() -> float:
    """Return operations a second of a matrix product: what one core's multipliers can do."""
    a = np.ones((384, 384))
    took = interleaved_s({"": lambda: a @ a}, 41)[""]
    return 2 * 384**3 / took


def show(problem: Problem) -> None:
    """Print a line for each contender, and the floor."""
    links = problem.robot.links
    steps = 6000 // links
    table = contenders(problem, steps)
    took = interleaved_s({name: work for name, (work, _) in table.items()}, ROUNDS)
    each = {name: took[name] / steps / count for name, (_, count) in table.items()}
    print(f"\n{problem.title}; per step and trajectory, medians of {ROUNDS} interleaved rounds")
    for name, one in each.items():
        print(f"  {name:22s} {one * 1e9:8.1f} ns  {each['Numba RK4, by hand'] / one:5.2f} x Numba")
    floor, best = operations(links) / matrix_product_rate(), f"{_core.instruction_sets()[0]}, batch"
    print(
        f"  floor of a batch: {operations(links)} operations (a fused one counts two) at the rate "
        f"of a matrix\n  product here, {floor * 1e9:.1f} ns; it takes {each[best] / floor:.1f} "
        "times that: a matrix product is all fused, of these\n  operations one in three is, and "
        "the sines choose quadrants, which counts as nothing.\n"
        f"  It reads {8 * READ * links} and writes {8 * WRITTEN * links} bytes of "
        f"{4 * 8 * KEPT * links / 1024:.0f} kB for four gaits, less of a floor: "
        "two reads\n  and a write of a pack go with every two multiplications. One run alone "
        "waits for itself:\n  each stage needs the sum over links of the stage before."
    )


def main() -> None:
    """Print the table for the paper's snake, and for a long one."""
    print(f"{platform.processor() or platform.machine()}, Python {platform.python_version()}")
    for name in ("paper6_k1e3", "n50_k1e5"):
        show(next(p for p in problems() if p.name == name))


if __name__ == "__main__":
    main()
