"""Time the exact model's methods against Numba's and SciPy's Dormand-Prince at the same error.

The floor of a step, six links, counted in operations at four a cycle (two a vector, one product and
one sum at a time) and 3 GHz. dop853: 12 rates of 7 sine-cosine pairs (12 ns each in the library)
and 500 operations, 1500 for their sums, 1.6 us. collocation, a piece that is known: 2 to 3
iterations of 432 operations and 900 for the rest, 0.2 us; one that is new: 7 shapes, and 18
unknowns eliminated with 16 right-hand sides, 18 000 operations, 2.5 us.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import serpenoid as sn
from scipy.integrate import solve_ivp
from serpenoid import _core
from serpenoid.bench.peers.numba_equations import dop853_run, parameters, rate_array
from serpenoid.bench.problems import Array, Problem, problems
from serpenoid.simulation.core_run import core_request

WANTED = 1e-6  # largest error of the end state, scaled as in Problem.error
TOLERANCES = 10.0 ** np.arange(-3.0, -10.0, -0.5)
REPEATS = 31
SCIPY_UP_TO_S = 10.0  # a hundred times slower than the rest
COLUMNS = ("x_m", "y_m", "theta_rad", "vx_m_s", "vy_m_s", "omega_rad_s")
Solve = Callable[[float], Array]  # tolerance -> end state


def contenders(problem: Problem) -> dict[str, Solve]:
    """Return every contender: the same start, the end state as the only thing recorded.

    Ours are timed twice: as the public call, which checks the scene, and in the core alone.
    """
    p, y0, end = parameters(problem), problem.first, problem.duration_s

    def scenes(method: str) -> dict[float, sn.Scene]:
        scene = problem.scene(method=method, start=problem.start, dt_s=end, record_every=1)
        return {tol: replace(scene, tolerance=tol) for tol in TOLERANCES}

    def call(method: str) -> Solve:
        by = scenes(method)
        return lambda tol: problem.vector(sn.simulate(by[tol]).state())

    def core(method: str) -> Solve:
        by = {tol: core_request(scene) for tol, scene in scenes(method).items()}
        start = problem.start.packed()

        def solve(tol: float) -> Array:
            out = _core.run(by[tol], start, None)
            return np.array([out[name][-1, 0] for name in COLUMNS])

        return solve

    def scipy(tol: float) -> Array:
        def rate(t: float, y: Array) -> Array:
            return rate_array(False, t, y, p)

        return solve_ivp(rate, (0.0, end), y0, "DOP853", rtol=tol, atol=0.1 * tol).y[:, -1]

    found: dict[str, Solve] = {
        "collocation": call("collocation"),
        "collocation, core alone": core("collocation"),
        "dop853": call("dop853"),
        "dop853, core alone": core("dop853"),
        "Numba DOP853": lambda tol: dop853_run(False, y0, p, end, tol, 0.1 * tol, 10**7)[0],
    }
    return {**found, "SciPy DOP853, Numba rate": scipy} if end <= SCIPY_UP_TO_S else found


def good_enough(problem: Problem, solve: Solve, exact: Array) -> float:
    """Return the largest tolerance whose result, and that of all smaller ones, is as wanted."""
    found = TOLERANCES[-1]
    for tol in TOLERANCES[::-1]:
        if problem.error(solve(tol), exact) > WANTED:
            break
        found = tol
    return float(found)


def report(problem: Problem) -> None:
    """Print one line a contender: median time, the tolerance it took, its error, the ratio."""
    solvers = contenders(problem)
    exact = dop853_run(
        False, problem.first, parameters(problem), problem.duration_s, 1e-13, 1e-15, 10**7
    )[0]
    tolerance = {name: good_enough(problem, s, exact) for name, s in solvers.items()}
    taken: dict[str, list[float]] = {name: [] for name in solvers}
    for _ in range(REPEATS):
        for name, solve in solvers.items():
            solve(tolerance[name])  # what ran before has filled the caches with its own
            began = time.perf_counter()
            solve(tolerance[name])
            taken[name].append(time.perf_counter() - began)
    base = statistics.median(taken["Numba DOP853"])
    print(f"{problem.title}, {problem.duration_s:g} s, to {WANTED:g} at the end")
    for name, solve in solvers.items():
        median, tol = statistics.median(taken[name]), tolerance[name]
        print(
            f"  {name:26} {median * 1e6:9.0f} us  tolerance {tol:7.1e}  "
            f"error {problem.error(solve(tol), exact):.0e}  Numba / this = {base / median:6.2f}"
        )


def step_us(problem: Problem, method: str) -> float:
    """Return what a step costs in the core once the run is on its way, us."""
    taken, steps = [], []
    for duration in (5.0, 30.0):  # shorter than what a busy machine takes away at a time
        scene = problem.scene(method=method, duration_s=duration, dt_s=duration, tolerance=1e-6)
        request, start, times = core_request(scene), problem.start.packed(), []
        steps.append(_core.run(request, start, None)["steps"])
        for _ in range(REPEATS):
            began = time.perf_counter()
            _core.run(request, start, None)
            times.append(time.perf_counter() - began)
        taken.append(statistics.median(times))
    return 1e6 * (taken[1] - taken[0]) / (steps[1] - steps[0])


def main() -> None:
    """Report on short and long runs; the floor of the short ones is a call that does nothing."""
    paper = next(p for p in problems() if p.name == "paper6")
    nothing = paper.scene(method="collocation", duration_s=0.0)
    times = []
    for _ in range(REPEATS):
        began = time.perf_counter()
        sn.simulate(nothing)
        times.append(time.perf_counter() - began)
    print(f"a call of simulate() for 0 s: {statistics.median(times) * 1e6:.0f} us")
    for method in ("dop853", "collocation"):
        print(f"a step of {method}: {step_us(paper, method):.2f} us")
    for duration in (10.0, 100.0):
        report(replace(paper, duration_s=duration))


if __name__ == "__main__":
    main()
