"""SciPy, SUNDIALS and Numba kernels on the hand-written equations, compiled.

On dry ground general solvers need the sign smoothed: their setting is then the smoothing width, at
a tolerance fine enough not to show. Numba's RK4 takes the plain sign, as people do.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from ..problems import Array, Problem
from . import numba_equations as q
from .contender import STEPS_S, TOLERANCES, Contender, Work, even_step_s

WIDTHS_M_S = (1e-2, 3e-3, 1e-3, 1e-4, 1e-5, 1e-6)
DRY_TOLERANCE = 1e-7
MOST_STEPS = 10**8
Solve = Callable[[Problem, Array, float], Array]  # problem, parameters, tolerance -> end state


def _solver(problem: Problem, name: str, family: str, solve: Solve) -> Contender:
    """Make a contender of a solver with a tolerance: on dry ground the width is its setting."""
    dry = problem.ground.dry

    def work(setting: float) -> Work:
        width, tolerance = (setting, DRY_TOLERANCE) if dry else (0.0, setting)
        return partial(solve, problem, q.parameters(problem, width), tolerance)

    kind, settings = ("width_m_s", WIDTHS_M_S) if dry else ("tolerance", TOLERANCES)
    return Contender(name, family, kind, settings, work)


def _scipy(name: str, problem: Problem, p: Array, tolerance: float) -> Array:
    from scipy.integrate import solve_ivp

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


def _cvode(name: str, problem: Problem, p: Array, tolerance: float) -> Array:
    from sksundae.cvode import CVODE  # pyright: ignore[reportMissingImports] (an optional extra)

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


def _dop853(problem: Problem, p: Array, tolerance: float) -> Array:
    control = (tolerance, tolerance / 10, MOST_STEPS)
    end, steps = q.dop853_run(problem.implicit, problem.first, p, problem.duration_s, *control)
    if steps < 0:
        raise ArithmeticError(f"more than {MOST_STEPS} steps")
    return end


def scipy(problem: Problem) -> list[Contender]:
    """Return the solvers of solve_ivp."""
    names = ("RK45", "DOP853", "LSODA", "Radau", "BDF")
    return [_solver(problem, f"SciPy {name}", "SciPy", partial(_scipy, name)) for name in names]


def sundials(problem: Problem) -> list[Contender]:
    """Return CVODE's two families of multistep methods."""
    names = ("BDF", "Adams")
    return [_solver(problem, f"CVODE {name}", "SUNDIALS", partial(_cvode, name)) for name in names]


def numba(problem: Problem) -> list[Contender]:
    """Return the hand-written kernels: RK4 at fixed steps and DOP853."""

    def rk4(dt_s: float) -> Work:
        p, dt = q.parameters(problem), even_step_s(problem, dt_s)
        steps = round(problem.duration_s / dt)
        return lambda: q.rk4(problem.implicit, problem.first, p, dt, steps)

    return [
        Contender("Numba RK4", "Numba", "dt_s", STEPS_S, rk4),
        _solver(problem, "Numba DOP853", "Numba", _dop853),
    ]
