"""One way to solve a problem of the benchmark, ours or SciPy's, and what it is tried at."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from .problems import Array, Problem

Work = Callable[[], Array]
STEPS_S = (1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5)
TOLERANCES = (1e-3, 1e-5, 1e-7, 1e-9, 1e-11)


@dataclass(frozen=True)
class Contender:
    """Hold one way to solve a problem: work(setting) makes the call that is timed.

    setting: one of settings, loosest first; kind says what it is: "dt_s", "tolerance" or
    "width_m_s" (of the smoothed sign, at a tolerance that does not show).
    """

    name: str
    family: str
    kind: str
    settings: tuple[float, ...]
    work: Callable[[float], Work]


def even_step_s(problem: Problem, dt_s: float) -> float:
    """Return the step next to dt_s of which the duration is a whole number."""
    return problem.duration_s / max(1, round(problem.duration_s / dt_s))
