"""Error against run time: every contender on every scene, in one run, interleaved.

Times are processor time of the thread that solves (other load on the machine does not count, and
nobody has a second core), the median of rounds; in each round every contender has its turn. A run
that fails, overruns its limit or leaves the finite numbers is a row with the reason. An error is of
the end state, scaled, against a reference of the same model: what the implicit model's springs
themselves err is not in it.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from functools import lru_cache

import numpy as np

from ..child_process import Crashed, Failed, Limited, Overran
from ..contender import Contender, Work
from ..problems import Problem, problems
from ..reference import reference
from .contenders import contenders

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


@lru_cache
def _contenders(scene: str) -> tuple[Problem, dict[str, Contender]]:
    problem = next(p for p in problems() if p.name == scene)
    return problem, {one.name: one for one in contenders(problem)}


@lru_cache
def _work(scene: str, method: str, setting: float) -> Work:
    problem, all_of_them = _contenders(scene)
    return all_of_them[method].work(problem, setting)


@np.errstate(all="ignore")  # what overflows in a peer ends as a row
def _first(scene: str, method: str, setting: float) -> tuple[float, float]:
    """Return error and time of one run; what compiles does so before, at the loosest setting."""
    problem, all_of_them = _contenders(scene)
    if setting == all_of_them[method].settings[0]:
        _work(scene, method, setting)()
    work = _work(scene, method, setting)
    begin = time.thread_time()
    end = work()
    spent = time.thread_time() - begin
    if not np.isfinite(end).all():
        raise ArithmeticError("the end state is not finite")
    return problem.error(end, reference(problem).end), spent


@np.errstate(all="ignore")
def _again(scene: str, method: str, setting: float, times: int) -> float:
    """Return the time of one run, from so many in a row."""
    work = _work(scene, method, setting)
    begin = time.thread_time()
    for _ in range(times):
        work()
    return (time.thread_time() - begin) / times


def _try_all(child: Limited, scene: str, effort: Effort) -> list[Row]:
    """Run every contender once at every setting; past one overrun its tighter ones are not tried.

    A fixed step refused as too long does not end the row: a shorter one may be right.
    """
    problem, all_of_them = _contenders(scene)
    rows = []
    for one in all_of_them.values():
        overran = ""
        for setting in one.settings:
            row = Row(scene, one.name, one.family, one.kind, setting)
            row.simulated_s = problem.duration_s
            rows.append(row)
            if overran:
                row.note = f"{NOT_TRIED}: {overran} at the setting before"
                continue
            try:
                # what Numba compiles counts against the first limit: hence the margin
                margin = 60.0 if setting == one.settings[0] else 0.0
                row.error, row.time_s = child(
                    effort.limit_s + margin, _first, scene, one.name, setting
                )
            except (Overran, Crashed, Failed) as failure:
                row.note = str(failure)
                overran = "" if isinstance(failure, Failed) else str(failure)
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
            spent = child(30.0, _again, scene, row.method, row.setting, repeats)
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
            tell(f"{number} of {len(effort.scenes)}: {_contenders(scene)[0].title} ...")
            rows += measure(child, scene, effort)
    return rows


def as_dicts(rows: list[Row]) -> list[dict[str, object]]:
    """Return rows as dictionaries, for CSV and JSON."""
    return [asdict(row) for row in rows]
