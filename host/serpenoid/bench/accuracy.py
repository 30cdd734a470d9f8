"""Error against run time on the viscous scenes: this package beside SciPy and Numba kernels."""

from __future__ import annotations

import csv
import statistics
import time
from collections.abc import Callable, Iterator
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from ..errors import SerpenoidError
from ..scene import METHODS
from ..simulation import simulate
from .problems import Array, Problem, problems

Work = Callable[[], Array]
COLUMNS = ("scene", "method", "setting", "time_s", "error", "note")
STEPS_S = (1e-2, 3e-3, 1e-3, 3e-4, 1e-4)
TOLERANCES = (1e-3, 1e-6, 1e-9, 1e-11)


def _own(problem: Problem) -> Iterator[tuple[str, float, Work]]:
    def work(method: str, dt: float) -> Work:
        scene = {"method": method, "dt_s": dt, "start": problem.start, "record_every": 10**9}
        return lambda: problem.vector(simulate(problem.scene(**scene)).state())

    for method in METHODS:
        for dt in STEPS_S:
            even = problem.duration_s / round(problem.duration_s / dt)  # a run ends on a whole step
            yield f"serpenoid {method}", even, work(method, even)


def _peers(problem: Problem) -> Iterator[tuple[str, float, Work]]:
    from scipy.integrate import solve_ivp

    from . import numba_equations as q

    p, y0, end = q.parameters(problem), problem.first, problem.duration_s

    def rate(t: float, y: Array) -> Array:
        return q.rate_array(problem.implicit, t, y, p)

    def scipy(name: str, tol: float) -> Array:
        out = solve_ivp(rate, (0, end), y0, name, rtol=max(tol, 1e-13), atol=tol / 10)
        return out.y[:, -1] if out.success else np.full_like(y0, np.nan)

    for dt in STEPS_S:
        steps = round(end / dt)
        yield "Numba RK4", end / steps, lambda s=steps: q.rk4(problem.implicit, y0, p, end / s, s)
    for tol in TOLERANCES:
        yield "Numba DOP853", tol, lambda r=tol: q.dop853_run(
            problem.implicit, y0, p, end, r, r / 10, 10**7)[0]  # fmt: skip
        for name in ("RK45", "DOP853", "LSODA"):
            yield f"SciPy {name}, Numba rhs", tol, lambda m=name, r=tol: scipy(m, r)


def reference(problem: Problem) -> Array:
    """Return the end state by SciPy's DOP853 at 1e-13 on the NumPy equations."""
    from scipy.integrate import solve_ivp

    from .numpy_equations import rate_of

    span = (0, problem.duration_s)
    out = solve_ivp(rate_of(problem), span, problem.first, "DOP853", rtol=1e-13, atol=1e-15)
    return out.y[:, -1]


def measure(problem: Problem, rounds: int) -> list[dict[str, object]]:
    """Time every contender in interleaved rounds; failures are rows with their reason."""
    exact, rows, alive = reference(problem), [], []
    peers = _peers(problem) if find_spec("numba") else ()
    for name, setting, work in [*_own(problem), *peers]:
        row: dict[str, object] = dict(zip(COLUMNS, (problem.name, name, setting, "", "", ""),
                                          strict=True))  # fmt: skip
        rows.append(row)
        try:
            error = problem.error(work(), exact)
        except SerpenoidError as failure:
            row["note"] = str(failure)
            continue
        row["error"] = error
        if np.isfinite(error):
            alive.append((row, work, []))
        else:
            row["note"] = "not finite"
    for _ in range(rounds):
        for _, work, times in alive:
            begin = time.perf_counter()
            work()
            times.append(time.perf_counter() - begin)
    for row, _, times in alive:
        row["time_s"] = statistics.median(times)
    return rows


def run(out: Path, names: tuple[str, ...] = (), rounds: int = 5) -> list[dict[str, object]]:
    """Measure the viscous scenes named (all unless given) and write accuracy.csv into out."""
    chosen = [p for p in problems() if not p.ground.dry and (not names or p.name in names)]
    rows = [row for problem in chosen for row in measure(problem, rounds)]
    out.mkdir(parents=True, exist_ok=True)
    with (out / "accuracy.csv").open("w", newline="") as file:
        writer: csv.DictWriter[str] = csv.DictWriter(file, COLUMNS)
        writer.writeheader()
        writer.writerows(rows)
    return rows
