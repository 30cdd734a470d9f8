"""Time the stiff method on hard springs against SciPy, SUNDIALS and Numba at the same error.

Times are those of the processor, so that a busy machine does not lengthen the longer runs.
"""

from __future__ import annotations

import math
import statistics
import sys
import time
from collections.abc import Callable, Iterator

import numpy as np
import serpenoid as sn
from serpenoid import _core
from serpenoid.bench.peers import compiled as peers
from serpenoid.bench.peers.numba_equations import dop853_run, parameters
from serpenoid.bench.problems import PAPER_GROUND, Array, Problem, problems
from serpenoid.simulation.core_run import core_request

WANTED = 1e-6  # largest error of the end state, scaled as in Problem.error
TOLERANCES = tuple(10.0 ** np.arange(-3.0, -11.5, -0.5))
SPRINGS = ((1e7, 1.0), (1e7, 1e3), (1e8, 1.0), (1e8, 1e3))  # N/m, N s/m
LONGEST_S, ROUNDS = 5.0, 7
Solve = Callable[[float], Array]  # tolerance -> end state


def stiff(k: float, c: float) -> Problem:
    """Return the paper's six links on springs, one second from the slow manifold."""
    six = next(p for p in problems() if p.name == "paper6")
    return Problem(f"k{k:g}_c{c:g}", "", six.robot, PAPER_GROUND, six.gait, 1.0, k, c)


def own(problem: Problem) -> Iterator[tuple[str, Solve]]:
    """Yield the public call, which checks the scene, and the core alone."""

    def scene(tolerance: float) -> sn.Scene:
        return problem.scene(
            method="radau", tolerance=tolerance, start=problem.start, dt_s=problem.duration_s
        )

    yield "radau", lambda tol: problem.vector(sn.simulate(scene(tol)).state())
    start = problem.start.packed()
    requests = {tol: core_request(scene(tol)) for tol in TOLERANCES}

    def core(tol: float) -> Array:
        out = _core.run(requests[tol], start, None)
        places = [out[name][-1] for name in ("x_m", "y_m", "vx_m_s", "vy_m_s")]
        return np.concatenate([*places, out["theta_rad"][-1, :1], out["omega_rad_s"][-1, :1]])

    yield "radau, core alone", core


def others(problem: Problem) -> Iterator[tuple[str, Solve]]:
    """Yield every solver of the accuracy benchmark that has a tolerance, rates compiled."""
    for family in (peers.scipy, peers.sundials, peers.numba):
        for one in family(problem):
            if one.kind == "tolerance":
                yield one.name, lambda tol, one=one: one.work(tol)()


def good_enough(problem: Problem, solve: Solve, exact: Array) -> tuple[float, float] | str:
    """Return the loosest tolerance whose result is as wanted, and its error; or why there is none.

    The next tighter one must be as good, so that no lucky hit counts.
    """
    hit, error, tol = None, math.inf, TOLERANCES[0]
    for tol in TOLERANCES:
        begin = time.perf_counter()
        try:
            error = problem.error(solve(tol), exact)
        except ArithmeticError as failure:
            return f"failed at tolerance {tol:.0e}: {failure}"
        good = error <= WANTED
        if hit and good:
            return hit
        hit = (tol, error) if good else None
        if time.perf_counter() - begin > LONGEST_S:
            return hit or f"over {LONGEST_S:g} s at tolerance {tol:.0e} with error {error:.1e}"
    return hit or f"error {error:.1e} at tolerance {tol:.0e}"


def report(problem: Problem) -> float:
    """Print one line a contender; return the ratio of the best other to ours, public call."""
    exact = dop853_run(
        True, problem.first, parameters(problem), problem.duration_s, 1e-13, 1e-15, 10**8
    )[0]
    solvers = {**dict(own(problem)), **dict(others(problem))}
    found = {name: good_enough(problem, solve, exact) for name, solve in solvers.items()}
    hits = {name: hit[0] for name, hit in found.items() if not isinstance(hit, str)}
    times: dict[str, list[float]] = {name: [] for name in hits}
    for _ in range(ROUNDS):
        for name, taken in times.items():
            begin = time.process_time()
            solvers[name](hits[name])
            taken.append(time.process_time() - begin)
    median = {name: statistics.median(taken) for name, taken in times.items()}
    print(
        f"\nk = {problem.stiffness_n_m:g} N/m, c = {problem.damping_n_s_m:g} N s/m, 6 links, 1 s",
        flush=True,
    )
    for name, hit in found.items():
        if isinstance(hit, str):
            print(f"  {name:20s} {hit}")
            continue
        ratio = median[name] / median["radau"]
        print(
            f"  {name:20s} {median[name] * 1e3:9.3f} ms   tolerance {hit[0]:.0e}   "
            f"error {hit[1]:.1e}   {ratio:8.1f} x"
        )
    return min(t for name, t in median.items() if "radau" not in name) / median["radau"]


def main() -> int:
    """Print everything; the exit status tells whether ours is ten times faster everywhere."""
    worst = min(report(stiff(k, c)) for k, c in SPRINGS)
    print(f"\nat error {WANTED:.0e} the best other takes at least {worst:.0f} x the time of radau")
    return 0 if worst >= 10 else 1


if __name__ == "__main__":
    sys.exit(main())
