"""SciPy, SUNDIALS and Numba kernels on the hand-written equations, compiled.

On dry ground general solvers need the sign smoothed: their setting is then the smoothing width, at
a tolerance fine enough not to show. Numba's RK4 takes the plain sign, as people do.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..contender import STEPS_S, TOLERANCES, Contender, Work, even_step_s
from ..problems import Array, Problem
from . import numba_equations as q

WIDTHS_M_S = (1e-2, 3e-3, 1e-3, 1e-4, 1e-5, 1e-6)
DRY_TOLERANCE = 1e-7
MOST_STEPS = 10**8
Solve = Callable[[Problem, Array, float], Array]  # problem, parameters, tolerance -> end state


def _solver(problem: Problem, name: str, family: str, solve: Solve) -> Contender:
    """Make a contender of a solver with a tolerance: on dry ground the width is its setting."""
    if problem.ground.dry:
        return Contender(
            name,
            family,
            "width_m_s",
            WIDTHS_M_S,
            lambda p, width: _bound(solve, p, width, DRY_TOLERANCE),
        )
    return Contender(
        name, family, "tolerance", TOLERANCES, lambda p, tolerance: _bound(solve, p, 0.0, tolerance)
    )


def _bound(solve: Solve, problem: Problem, width_m_s: float, tolerance: float) -> Work:
    packed = q.parameters(problem, width_m_s)
    return lambda: solve(problem, packed, tolerance)


def scipy(problem: Problem) -> list[Contender]:
    """Return the solvers of solve_ivp."""
    from scipy.integrate import solve_ivp

    def solve(name: str) -> Solve:
        def work(problem: Problem, p: Array, tolerance: float) -> Array:
            out = solve_ivp(
                lambda t, y: q.rate_array(problem.implicit, t, y, p),
                (0, problem.duration_s),
                problem.first,
                name,
                rtol=max(tolerance, 1e-13),
                atol=tolerance / 10,
            )
            if not out.success:
                raise ArithmeticError(out.message)
            return out.y[:, -1]

        return work

    names = ("RK45", "DOP853", "LSODA", "Radau", "BDF")
    return [_solver(problem, f"SciPy {name}", "SciPy", solve(name)) for name in names]


def sundials(problem: Problem) -> list[Contender]:
    """Return CVODE's two families of multistep methods."""
    from sksundae.cvode import CVODE  # pyright: ignore[reportMissingImports] (an optional extra)

    def solve(name: str) -> Solve:
        def work(problem: Problem, p: Array, tolerance: float) -> Array:
            solver = CVODE(
                lambda t, y, dy: q.fill_rate(problem.implicit, t, y, p, dy),
                method=name,
                rtol=tolerance,
                atol=tolerance / 10,
                max_num_steps=MOST_STEPS,
            )
            times = np.linspace(0, problem.duration_s, 3)  # of two, every step would be kept
            out = solver.solve(times, problem.first)
            if not out.success:
                raise ArithmeticError(out.message)
            return out.y[-1]

        return work

    return [_solver(problem, f"CVODE {name}", "SUNDIALS", solve(name)) for name in ("BDF", "Adams")]


def numba(problem: Problem) -> list[Contender]:
    """Return the hand-written kernels: RK4 at fixed steps and DOP853."""

    def dop853(problem: Problem, p: Array, tolerance: float) -> Array:
        end, steps = q.dop853_run(
            problem.implicit,
            problem.first,
            p,
            problem.duration_s,
            tolerance,
            tolerance / 10,
            MOST_STEPS,
        )
        if steps < 0:
            raise ArithmeticError(f"more than {MOST_STEPS} steps")
        return end

    def rk4(problem: Problem, dt_s: float) -> Work:
        p, dt = q.parameters(problem), even_step_s(problem, dt_s)
        steps = round(problem.duration_s / dt)
        return lambda: q.rk4(problem.implicit, problem.first, p, dt, steps)

    return [
        Contender("Numba RK4", "Numba", "dt_s", STEPS_S, rk4),
        _solver(problem, "Numba DOP853", "Numba", dop853),
    ]
