"""Extreme scenes by every method: a run meets the error it states, or stops and says why.

What a run states: an adaptive method its tolerance, a fixed step what half the step changes
(Richardson, by the method's order). Outcomes: "met", the true error is within ten times that (for
a tolerance, which is of one step: a thousand times, ten times a cycle beyond 100 cycles); "rough",
it says itself that it is off by a tenth or more; "refused", "diverged" and "bad input", it stopped
and said so; "UNTRUE", "HUNG", "CRASHED" are defects. The truth is SciPy's
DOP853 on equations in plain NumPy; a scene for which it takes longer than a minute has none.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

from ...model.gait import Gait
from ...model.ground import Ground
from ...simulation.methods import METHODS
from ...simulation.simulate import simulate
from ..child_process import Crashed, Failed, Limited, Overran
from ..problems import PAPER_GROUND, Array, Problem, gait_deg, paper_robot, reference
from ..scipy_peer import solve

TOLERANCE = 1e-7
TRUTH_TOLERANCE, TRUTH_LIMIT_S = 1e-11, 60.0
SAID = {"StepTooLarge": "refused", "Diverged": "diverged", "BadInput": "bad input"}
DEFECTS = ("UNTRUE", "HUNG", "CRASHED", "FAILED")


@dataclass(frozen=True, slots=True)
class Extreme:
    """Hold an extreme scene: the problem, the fixed step, and the limit of processor time."""

    problem: Problem
    dt_s: float
    limit_s: float
    quick: bool


@dataclass(frozen=True, slots=True)
class Outcome:
    """Hold what became of one run; stated and error are scaled as Problem.error (nan: none)."""

    scene: str
    method: str
    outcome: str
    stated: float = math.nan
    error: float = math.nan
    time_s: float = math.nan
    said: str = ""


def _extreme(
    name: str, dt_s: float = 1e-3, limit_s: float = 20.0, quick: bool = True, **changes: Any
) -> Extreme:
    """Return the paper's scene of 5 s with fields of the problem changed."""
    usual = Problem(name, name, paper_robot(), PAPER_GROUND, gait_deg(30, 80, 5), 5.0)
    return Extreme(replace(usual, **changes), dt_s, limit_s, quick)


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
        one("alpha 170 deg", gait=wide),
        one("alpha 170 deg, k = 1e4, c = 1", gait=wide, **k(1e4, 1.0)),
        one("omega 0.01 rad/s", 1e-2, gait=slow, duration_s=200.0),
        one("omega 100 rad/s", 1e-4, gait=fast, duration_s=1.0),
        one("omega 100 rad/s, k = 1e3, c = 1", 1e-4, gait=fast, duration_s=1.0, **k(1e3, 1.0)),
        one("cn/ct = 1e-6", ground=Ground(ct=10.0, cn=1e-5)),
        one("cn/ct = 1e6", ground=Ground(ct=1e-5, cn=10.0)),
        one("mass 1e-6 kg", robot=light, duration_s=1.0),
        one("mass 1e-6 kg, dt 0.1 us", 1e-7, robot=light, duration_s=0.02),
        one("mass 1e3 kg", robot=paper_robot(mass_kg=1e3)),
        one("no friction", ground=free),
        one("no friction, k = 1e3, c = 0", ground=free, duration_s=20.0, **soft),
        one("k = 1e3, c = 0", duration_s=50.0, **soft),
        one("k = 9e5, c = 1 at 1 ms", **k(9e5, 1.0)),
        one("k = 2.2e6, c = 1 at 1 ms", **k(2.2e6, 1.0)),
        one("k = 1e9, c = 1e5", 1e-4, duration_s=0.1, **k(1e9, 1e5)),
        one("hard stick", **stick),
        one("1000 links", quick=False, duration_s=1.0, **chain),
        one("1000 links, k = 1e5, c = 10", quick=False, duration_s=0.5, **chain, **k(1e5, 10.0)),
        one("24 h", 1e-2, 300.0, quick=False, duration_s=86400.0),
    )


def truth(extreme: Extreme) -> Array:
    """Return a scene's end state by code that shares nothing with the core."""
    problem = extreme.problem
    dry = problem.ground.dry
    return reference(problem).end if dry else solve(problem, "DOP853", TRUTH_TOLERANCE)


def _end(extreme: Extreme, method: str, **control: float) -> Array:
    problem = extreme.problem
    fields = {"method": method, "start": problem.start, "record_every": 10**9, **control}
    return problem.vector(simulate(problem.scene(**fields)).state())


def judge(extreme: Extreme, method: str, exact: Array | None) -> Outcome:
    """Run one method on one extreme scene and say what became of it; exact: the true end."""
    problem, kind = extreme.problem, METHODS[method]
    adaptive = problem.formulation in kind.adaptive
    control = {"tolerance": TOLERANCE} if adaptive else {"dt_s": extreme.dt_s}
    begin = time.thread_time()
    end = _end(extreme, method, **control)
    spent = time.thread_time() - begin
    stated, error, word = TOLERANCE, math.nan, "no reference"
    if not adaptive:
        half = _end(extreme, method, dt_s=extreme.dt_s / 2)
        stated = problem.error(end, half) / (1 - 0.5**kind.order)
    if exact is not None:
        error = problem.error(end, exact)
        # rounding of many steps is in no estimate
        # a tolerance is of a step: in the neutral coordinates what the cycles leave adds up
        cycles = problem.duration_s / problem.gait.period_s
        allowed = (1e3 * max(1.0, cycles / 100) if adaptive else 10) * stated + 1e-9
        word = "rough" if stated >= 0.1 else "met" if error <= allowed else "UNTRUE"
    return Outcome(problem.name, method, word, stated, error, spent)


def run(quick: bool, tell: Callable[[str], None]) -> Iterator[Outcome]:
    """Yield the outcome of every extreme scene by every method that runs it."""
    with Limited() as child:
        for extreme in extremes():
            if extreme.quick or not quick:
                tell(f"extreme: {extreme.problem.name} ...")
                exact = _truth_in_time(child, extreme)
                for method in extreme.problem.methods():
                    yield _judged(child, extreme, method, exact)


def _truth_in_time(child: Limited, extreme: Extreme) -> Array | None:
    """Return the true end, or None where it takes too long or the scene is refused."""
    try:
        return child(TRUTH_LIMIT_S, truth, extreme)
    except Overran:
        return None
    except Failed as failure:
        if str(failure).partition(": ")[0] not in SAID:
            raise
        return None


def _judged(child: Limited, extreme: Extreme, method: str, exact: Array | None) -> Outcome:
    try:
        return child(extreme.limit_s, judge, extreme, method, exact)
    except Failed as failure:
        error, _, said = str(failure).partition(": ")
        word = SAID.get(error, "FAILED")
    except (Overran, Crashed) as failure:
        word, said = "HUNG" if isinstance(failure, Overran) else "CRASHED", str(failure)
    return Outcome(extreme.problem.name, method, word, said=said)
