"""Extreme scenes by every method: a run meets the error it states, or stops and says why.

Outcomes: "met", the true error of places and angles is within 1.5 times the run's error_estimate;
"not settled", the run says that its estimate is no bound; "refused", "diverged" and "bad input",
it stopped and said so; "SILENTLY WRONG", "HANG", "NaN" and "CRASH" are defects. The truth is
SciPy's DOP853 on equations in plain NumPy; a scene that takes it too long has none.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..model.gait import Gait
from ..model.ground import Ground
from ..simulation.simulate import simulate
from .child_process import Crashed, Failed, Limited, Overran
from .problems import PAPER_GROUND, Array, Problem, gait_deg, paper_robot, reference
from .scipy_peer import solve
from .work_precision import contenders

LIMIT_S = 20.0  # Processor time of a run and of the finer ones that tell its error
TRUTH_TOLERANCE, TRUTH_LIMIT_S = 1e-11, 6.0
TRUTH_ERROR = 1e-8  # Error of the truth, and rounding over many steps
SAID = {"StepTooLarge": "refused", "Diverged": "diverged", "BadInput": "bad input"}
DEFECTS = ("HANG", "NaN", "SILENTLY WRONG", "CRASH")


@dataclass(frozen=True, slots=True)
class Extreme:
    """Hold an extreme scene: the problem, the fixed step, and whether a quick look has it."""

    problem: Problem
    dt_s: float
    quick: bool


@dataclass(frozen=True, slots=True)
class Outcome:
    """Hold what became of one run; stated and true error in body lengths and radians."""

    scene: str
    method: str
    outcome: str
    stated: float = math.nan
    error: float = math.nan
    said: str = ""


def _extreme(name: str, dt_s: float = 1e-3, quick: bool = True, **changes: Any) -> Extreme:
    """Return the paper's scene of 5 s with fields of the problem changed."""
    usual = Problem(name, name, paper_robot(), PAPER_GROUND, gait_deg(30, 80, 5), 5.0)
    return Extreme(replace(usual, **changes), dt_s, quick)


def _springs(k: float, c: float) -> dict[str, Any]:
    return {"stiffness_n_m": k, "damping_n_s_m": c}


def extremes() -> tuple[Extreme, ...]:
    """Return every extreme scene."""
    one, k = _extreme, _springs
    wide, fast, light = gait_deg(170, 80, 5), gait_deg(30, 80, 100), paper_robot(mass_kg=1e-6)
    slow, free, soft = gait_deg(30, 80, 0.01), Ground(0.0, 0.0), k(1e3, 0.0)
    chain: dict[str, Any] = {
        "robot": paper_robot(1000),
        "gait": Gait(math.radians(10), 4 * math.pi / 999, 5.0),
    }
    stick: dict[str, Any] = {"ground": Ground(0.1, 10.0, 5.0, 5.0), "gait": gait_deg(30, 80, 1)}
    return (
        one("alpha 170 deg", gait=wide, duration_s=1.0),
        one("alpha 170 deg, k = 1e4, c = 1", quick=False, gait=wide, **k(1e4, 1.0)),
        one("omega 0.01 rad/s", 1e-2, quick=False, gait=slow, duration_s=200.0),
        one("omega 100 rad/s", 1e-4, gait=fast, duration_s=0.3),
        one("omega 100 rad/s, k = 1e3, c = 1", 1e-4, gait=fast, duration_s=1.0, **k(1e3, 1.0)),
        one("cn/ct = 1e-6", ground=Ground(ct=10.0, cn=1e-5)),
        one("cn/ct = 1e6", ground=Ground(ct=1e-5, cn=10.0)),
        one("mass 1e-6 kg", quick=False, robot=light, duration_s=0.1),
        one("mass 1e-6 kg, dt 0.1 us", 1e-7, quick=False, robot=light, duration_s=2e-3),
        one("mass 1e3 kg", robot=paper_robot(mass_kg=1e3)),
        one("no friction", ground=free),
        one("no friction, k = 1e3, c = 0", quick=False, ground=free, duration_s=20.0, **soft),
        one("k = 1e3, c = 0", quick=False, duration_s=50.0, **soft),
        one("k = 9e5, c = 1 at 1 ms", duration_s=0.1, **k(9e5, 1.0)),
        one("k = 2.2e6, c = 1 at 1 ms", quick=False, duration_s=1.0, **k(2.2e6, 1.0)),
        one("k = 1e9, c = 1e5", 1e-4, quick=False, duration_s=0.1, **k(1e9, 1e5)),
        one("hard stick", **stick),
        one("1000 links", quick=False, duration_s=1.0, **chain),
        one("1000 links, k = 1e5, c = 10", quick=False, duration_s=0.1, **chain, **k(1e5, 10.0)),
        one("an hour", 1e-2, quick=False, duration_s=3600.0),
    )


def _truth(problem: Problem) -> Array:
    dry = problem.ground.dry
    return reference(problem).end if dry else solve(problem, "DOP853", TRUTH_TOLERANCE)


def outcome_of(extreme: Extreme, method: str, exact: Array | None) -> Outcome:
    """Run one method on one extreme scene and say what became of it; exact: the true end."""
    problem = extreme.problem
    rare = {"record_every": 10**9, "start": problem.start}
    run = simulate(problem.scene(method=method, dt_s=extreme.dt_s, **rare))
    end, estimate = problem.vector(run.state()), run.error_estimate
    stated = estimate.integration.size(problem.robot.body_length_m)
    error, word = math.nan, "no reference"
    if not np.isfinite(end).all() or math.isnan(stated):
        word = "NaN"
    elif not estimate.settled:
        word = "not settled"
    elif exact is not None:
        error = problem.error(end, exact, problem.places)
        word = "met" if error <= 1.5 * stated + TRUTH_ERROR else "SILENTLY WRONG"
    return Outcome(problem.name, method, word, stated, error)


def measure(quick: bool, tell: Callable[[str], None]) -> Iterator[Outcome]:
    """Yield the outcome of every extreme scene by every method that runs it."""
    with Limited() as child:
        for extreme in extremes():
            if quick and not extreme.quick:
                continue
            problem = extreme.problem
            tell(f"extreme scenes: {problem.name} ...")
            try:
                exact = child(TRUTH_LIMIT_S, _truth, problem)
            except (Overran, Failed):  # too long, or refused as all methods will refuse it
                exact = None
            methods = [one.name for one in contenders(problem) if "SciPy" not in one.name]
            for method in methods:
                try:
                    yield child(LIMIT_S, outcome_of, extreme, method, exact)
                except Failed as failure:
                    error, _, said = str(failure).partition(": ")
                    yield Outcome(problem.name, method, SAID.get(error, "CRASH"), said=said)
                except (Overran, Crashed) as failure:
                    word = "HANG" if isinstance(failure, Overran) else "CRASH"
                    yield Outcome(problem.name, method, word, said=str(failure))
