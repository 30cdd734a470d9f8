"""Extreme scenes by every method: a run meets the error it states, or stops and says why.

What a run states: an adaptive method its tolerance, a fixed step what half the step changes
(Richardson, by the method's order). Outcomes: "met", the true error is within ten times that (for
a tolerance, which is of one step: a thousand times, ten times a cycle beyond 100 cycles); "rough",
it says itself that it is off by a tenth or more; "refused", "diverged" and "bad input", it stopped
and said so; "UNTRUE", "HUNG", "CRASHED" are defects. The truth is Numba's DOP853 on the
hand-written equations; without Numba it is missing.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from importlib.util import find_spec

from ...model.errors import BadInput, Diverged, StepTooLarge
from ...model.gait import Gait
from ...model.ground import Ground
from ...model.robot import Robot
from ...simulation.methods import METHODS
from ...simulation.simulate import simulate
from ..child_process import Crashed, Failed, Limited, Overran
from ..problems import PAPER_GROUND, Array, Problem
from ..reference import reference

TOLERANCE = 1e-7
SAID = {StepTooLarge: "refused", Diverged: "diverged", BadInput: "bad input"}
DEFECTS = ("UNTRUE", "HUNG", "CRASHED", "FAILED")


@dataclass(frozen=True, slots=True)
class Extreme:
    """Hold an extreme scene: the problem, the fixed step, and the limit of processor time."""

    problem: Problem
    dt_s: float = 1e-3
    limit_s: float = 20.0
    quick: bool = True


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


def _gait(alpha_deg: float, beta_deg: float, omega_rad_s: float) -> Gait:
    return Gait(math.radians(alpha_deg), math.radians(beta_deg), omega_rad_s)


def _paper(links: int = 6, mass_kg: float = 1.0) -> Robot:
    return Robot(links, mass_kg, 0.12)


def extremes() -> tuple[Extreme, ...]:
    """Return every extreme scene."""
    usual, six, ground = _gait(30, 80, 5), _paper(), PAPER_GROUND
    wave = Gait(math.radians(10), 4 * math.pi / 999, 5.0)

    def one(
        name: str,
        robot: Robot = six,
        ground: Ground = ground,
        gait: Gait = usual,
        duration_s: float = 5.0,
        k: float = 0.0,
        c: float = 0.0,
        **more: float | bool,
    ) -> Extreme:
        problem = Problem(name, name, robot, ground, gait, duration_s, k, c)
        return Extreme(problem, **more)  # type: ignore[arg-type]

    return (
        one("alpha 170 deg", gait=_gait(170, 80, 5)),
        one("alpha 170 deg, k = 1e4, c = 1", gait=_gait(170, 80, 5), k=1e4, c=1.0),
        one("omega 0.01 rad/s", gait=_gait(30, 80, 0.01), duration_s=200.0, dt_s=1e-2),
        one("omega 100 rad/s", gait=_gait(30, 80, 100), duration_s=1.0, dt_s=1e-4),
        one(
            "omega 100 rad/s, k = 1e3, c = 1",
            gait=_gait(30, 80, 100),
            duration_s=1.0,
            k=1e3,
            c=1.0,
            dt_s=1e-4,
        ),
        one("cn/ct = 1e-6", ground=Ground(ct=10.0, cn=1e-5)),
        one("cn/ct = 1e6", ground=Ground(ct=1e-5, cn=10.0)),
        one("mass 1e-6 kg", robot=_paper(mass_kg=1e-6), duration_s=1.0),
        one("mass 1e-6 kg, dt 0.1 us", robot=_paper(mass_kg=1e-6), duration_s=0.02, dt_s=1e-7),
        one("mass 1e3 kg", robot=_paper(mass_kg=1e3)),
        one("no friction", ground=Ground(0.0, 0.0)),
        one("no friction, k = 1e3, c = 0", ground=Ground(0.0, 0.0), k=1e3, duration_s=20.0),
        one("k = 1e3, c = 0", k=1e3, duration_s=50.0),
        one("k = 9e5, c = 1 at 1 ms", k=9e5, c=1.0),
        one("k = 2.2e6, c = 1 at 1 ms", k=2.2e6, c=1.0),
        one("k = 1e9, c = 1e5", k=1e9, c=1e5, duration_s=0.1, dt_s=1e-4),
        one("hard stick", ground=Ground(0.1, 10.0, 5.0, 5.0), gait=_gait(30, 80, 1)),
        one("1000 links", robot=_paper(1000), gait=wave, duration_s=1.0, quick=False),
        one(
            "1000 links, k = 1e5, c = 10",
            robot=_paper(1000),
            gait=wave,
            duration_s=0.5,
            k=1e5,
            c=10.0,
            quick=False,
        ),
        one("24 h", duration_s=86400.0, dt_s=1e-2, limit_s=300.0, quick=False),
    )


@lru_cache
def truth(name: str) -> Array | None:
    """Return a scene's end state by code that shares nothing with the core, or None without it."""
    problem = next(e.problem for e in extremes() if e.problem.name == name)
    if problem.ground.dry:
        return reference(problem).end
    if not find_spec("numba"):
        return None
    from ..peers import numba_equations as q

    args = (problem.first, q.parameters(problem), problem.duration_s, 1e-12, 1e-14, 10**8)
    end, steps = q.dop853_run(problem.implicit, *args)
    return end if steps > 0 else None


def _end(extreme: Extreme, method: str, **control: float) -> Array:
    problem = extreme.problem
    fields = {"method": method, "start": problem.start, "record_every": 10**9, **control}
    return problem.vector(simulate(problem.scene(**fields)).state())


def _stated_and_end(extreme: Extreme, method: str) -> tuple[float, Array, float]:
    """Return what a run states of its error, its end state, and its time."""
    kind = METHODS[method]
    begin = time.thread_time()
    if extreme.problem.formulation in kind.adaptive:
        end = _end(extreme, method, tolerance=TOLERANCE)
        return TOLERANCE, end, time.thread_time() - begin
    end = _end(extreme, method, dt_s=extreme.dt_s)
    spent = time.thread_time() - begin
    half = _end(extreme, method, dt_s=extreme.dt_s / 2)
    return extreme.problem.error(end, half) / (1 - 0.5**kind.order), end, spent


def judge(name: str, method: str) -> Outcome:
    """Run one method on one extreme scene and say what became of it."""
    extreme = next(e for e in extremes() if e.problem.name == name)
    exact = truth(name)
    try:
        stated, end, spent = _stated_and_end(extreme, method)
    except (StepTooLarge, Diverged, BadInput) as said:
        return Outcome(name, method, SAID[type(said)], said=str(said))
    if exact is None:
        return Outcome(name, method, "no reference", stated, time_s=spent)
    error = extreme.problem.error(end, exact)
    adaptive = extreme.problem.formulation in METHODS[method].adaptive
    # rounding of many steps is in no estimate
    # a tolerance is of a step: in the neutral coordinates what the cycles leave adds up
    cycles = extreme.problem.duration_s / extreme.problem.gait.period_s
    allowed = (1e3 * max(1.0, cycles / 100) if adaptive else 10) * stated + 1e-9
    word = "met" if error <= allowed else "UNTRUE"
    if stated >= 0.1:
        word = "rough"
    return Outcome(name, method, word, stated, error, spent)


def run(quick: bool, tell: Callable[[str], None]) -> list[Outcome]:
    """Return the outcome of every extreme scene by every method that runs it."""
    found = []
    with Limited() as child:
        for extreme in extremes():
            if quick and not extreme.quick:
                continue
            tell(f"extreme: {extreme.problem.name} ...")
            found += [_judged(child, extreme, method) for method in _methods(extreme.problem)]
    return found


def _methods(problem: Problem) -> list[str]:
    law = "dry" if problem.ground.dry else "viscous"
    return [
        name
        for name, kind in METHODS.items()
        if problem.formulation in kind.formulations and law in kind.laws
    ]


def _judged(child: Limited, extreme: Extreme, method: str) -> Outcome:
    name = extreme.problem.name
    try:
        child(60.0, truth, name)  # found once, and not on the clock of a method
        return child(extreme.limit_s, judge, name, method)
    except Overran as failure:
        return Outcome(name, method, "HUNG", said=str(failure))
    except Crashed as failure:
        return Outcome(name, method, "CRASHED", said=str(failure))
    except Failed as failure:
        return Outcome(name, method, "FAILED", said=str(failure))
