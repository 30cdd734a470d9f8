"""Error against run time: every contender on every scene, in one run, interleaved.

Times are processor time of the thread that solves (other load on the machine does not count, and
nobody has a second core), the median of rounds; in each round every contender has its turn. A run
that fails, overruns its limit or leaves the finite numbers is a row with the reason. An error is of
the end state, scaled, against a reference of the same model: what the implicit model's springs
themselves err is not in it."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np

from ...simulation.methods import METHODS
from ...simulation.simulate import simulate
from ..child_process import Crashed, Failed, Limited, Overran
from ..contender import STEPS_S, TOLERANCES, Contender, Work, even_step_s
from ..problems import Problem, problems, reference
from ..scipy_peer import scipy

NOT_TRIED = "not tried"
LEAST_TIMED_S = 2e-3  # shorter work is repeated within a round


@dataclass(slots=True)
class Row:
    """Hold what one contender did at one setting; error and times are None where it failed."""

    scene: str
    method: str
    family: str
    kind: str
    setting: float
    error: float | None = None
    time_s: float | None = None
    spread: float | None = None  # quartiles of the rounds, relative to the median
    rounds: int = 0
    simulated_s: float = 0.0
    note: str = ""


@dataclass(frozen=True, slots=True)
class Effort:
    """Say how much to measure: quick for a look, full for the figures quoted."""

    scenes: tuple[str, ...] = field(default_factory=lambda: tuple(p.name for p in problems()))
    rounds: int = 5
    limit_s: float = 2.0  # of one run
    budget_s: float = 8.0  # of the rounds of a scene, after the first runs


QUICK = Effort(("paper6", "paper6_k1e3", "robot2005"), rounds=3, limit_s=0.4, budget_s=3.0)


def _problem(scene: str) -> Problem:
    return next(p for p in problems() if p.name == scene)


@lru_cache
def _work(scene: str, method: str, setting: float) -> Work:
    return next(c for c in contenders(_problem(scene)) if c.name == method).work(setting)


@np.errstate(all="ignore")  # what overflows in SciPy ends as a row
def _timed(scene: str, method: str, setting: float, repeats: int = 1) -> tuple[float, float]:
    """Return the error and the time of a run, from so many in a row."""
    problem, work = _problem(scene), _work(scene, method, setting)
    begin = time.thread_time()
    for _ in range(repeats - 1):
        work()
    end = work()
    spent = (time.thread_time() - begin) / repeats
    if not np.isfinite(end).all():
        raise ArithmeticError("the end state is not finite")
    return problem.error(end, reference(problem).end), spent


def _try_all(child: Limited, scene: str, effort: Effort) -> list[Row]:
    """Run every contender once at every setting; past one overrun its tighter ones are not tried.

    A fixed step refused as too long does not end the row: a shorter one may be right.
    """
    problem = _problem(scene)
    rows = []
    for one in contenders(problem):
        overran = ""
        for setting in one.settings:
            row = Row(scene, one.name, one.family, one.kind, setting)
            row.simulated_s = problem.duration_s
            rows.append(row)
            if overran:
                row.note = f"{NOT_TRIED}: {overran} at the setting before"
                continue
            run = (_timed, scene, one.name, setting)
            try:
                row.error, row.time_s = child(effort.limit_s, *run)
            except Failed as failure:
                row.note = str(failure)
            except (Overran, Crashed) as failure:
                row.note = overran = str(failure)
            if row.time_s is not None and row.time_s > effort.limit_s / 2:
                overran = f"took {row.time_s:.1f} s"
    return rows


def measure(child: Limited, scene: str, effort: Effort) -> list[Row]:
    """Return the rows of one scene, timed in interleaved rounds until its budget is spent."""
    rows = _try_all(child, scene, effort)
    alive = [(row, [row.time_s]) for row in rows if row.time_s is not None]
    # whatever is slow has fewer turns: what a round costs must leave every one its share
    left = effort.budget_s
    for number in range(effort.rounds):
        most_s = effort.limit_s / (1 + number)
        for row, times in alive:
            if times[0] > min(most_s, left):
                continue
            repeats = max(1, round(LEAST_TIMED_S / max(times[0], 1e-7)))
            _, spent = child(30.0, _timed, scene, row.method, row.setting, repeats)
            times.append(spent)
            left -= spent * repeats
    for row, times in alive:
        timed = times[1:] or times  # the first run also warms caches
        row.time_s, row.rounds = statistics.median(timed), len(timed)
        if len(timed) > 2:
            low, _, high = statistics.quantiles(timed, n=4)
            row.spread = (high - low) / row.time_s
    return rows


def run(effort: Effort, tell: Callable[[str], None]) -> list[Row]:
    """Measure the scenes of an effort, telling what is under way."""
    rows = []
    with Limited() as child:
        for number, scene in enumerate(effort.scenes, 1):
            tell(f"{number} of {len(effort.scenes)}: {_problem(scene).title} ...")
            rows += measure(child, scene, effort)
    return rows


OWN = "serpenoid"


def _own(problem: Problem, method: str) -> Contender:
    adaptive = problem.formulation in METHODS[method].adaptive

    def work(setting: float) -> Work:
        control = {"tolerance": setting} if adaptive else {"dt_s": even_step_s(problem, setting)}
        fields = {"method": method, "start": problem.start, "record_every": 10**9, **control}
        scene = problem.scene(**fields)  # made beforehand, and not timed
        return lambda: problem.vector(simulate(scene), -1)

    kind, settings = ("tolerance", TOLERANCES) if adaptive else ("dt_s", STEPS_S)
    return Contender(f"{OWN} {method}", OWN, kind, settings, work)


def contenders(problem: Problem) -> list[Contender]:
    """Return everyone who solves a problem here."""
    return [*(_own(problem, method) for method in problem.methods()), *scipy(problem)]
