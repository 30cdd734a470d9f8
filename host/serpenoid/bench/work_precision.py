"""Measure error against run time of every method and of SciPy's solvers, for both models.

A time is the median processor time of the solving thread for a simulated second. An error is the
scaled difference of the end state from a reference of the same model, so that it does not contain
the modelling error of the implicit model's springs. A run that fails, takes too long or gives
infinite numbers is a row with the reason.
"""

from __future__ import annotations

import math
import platform
import statistics
import time
import timeit
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from .. import _core
from ..simulation.scene import METHODS, objection
from ..simulation.simulate import simulate
from . import scipy_peer
from .child_process import Limited
from .problems import Array, Problem, problems, reference

PEER = "SciPy "  # Start of the names of SciPy's methods.
Work = Callable[[], Array]


@dataclass(frozen=True, slots=True)
class Row:
    """The result of one method at one setting.

    kind: the setting's name, "dt_s", "tolerance" or "width_m_s". error: scaled error of the end
    state. time_s: processor time of a simulated second. Both are NaN if the run failed, with the
    reason in note.
    """

    scene: str
    method: str
    kind: str
    setting: float
    error: float = math.nan
    time_s: float = math.nan
    note: str = ""
    machine: str = ""


def contenders(problem: Problem) -> list[tuple[str, str, tuple[float, ...]]]:
    """Return the name of every method, ours and SciPy's, with its setting's name and values.

    On dry ground the setting of SciPy's methods is the width of the smoothed sign function.
    """
    scene, methods = problem.scene, []
    tolerances = "tolerance", (1e-3, 1e-5, 1e-7, 1e-9, 1e-11)
    steps = "dt_s", (1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5)
    widths = "width_m_s", (1e-2, 3e-3, 1e-3, 1e-4, 1e-5, 1e-6)
    for name, kind in METHODS.items():
        if objection(name, scene) is None:
            setting = tolerances if scene.formulation in kind.adaptive else steps
            methods.append((name, *setting))
    setting = widths if scene.law == "dry" else tolerances
    return methods + [(PEER + name, *setting) for name in scipy_peer.METHODS]


def work_of(problem: Problem, method: str, kind: str, setting: float) -> Work:
    """Return the function to be timed, which returns the end state of a method at a setting."""
    if method.startswith(PEER):
        # With a smoothed sign the tolerance 1e-7 is well below the error by the width.
        tolerances = (1e-7, setting) if kind == "width_m_s" else (setting,)
        return partial(scipy_peer.solve, problem, method.removeprefix(PEER), *tolerances)
    scene = problem.scene
    if kind == "dt_s":  # The duration must be a whole number of steps.
        setting = scene.duration_s / max(1, round(scene.duration_s / setting))
    changes: dict[str, Any] = {"method": method, "start": problem.start, kind: setting}
    scene = replace(scene, record_every=10**9, **changes)
    return lambda: problem.vector(simulate(scene).state())


@np.errstate(all="ignore")  # An overflow in SciPy becomes a row with a note.
def _timed(problem: Problem, work: tuple[str, str, float], rounds: int) -> tuple[float, float]:
    """Return error and time of a run; the time is a median over rounds if the run is short."""
    call = work_of(problem, *work)
    begin_s = time.thread_time()
    end = call()
    times_s, long_s = [time.thread_time() - begin_s], 0.1
    if times_s[0] < long_s:
        # Work shorter than 2 ms is repeated within a round.
        count = max(1, round(2e-3 / max(times_s[0], 1e-7)))
        rounds_s = timeit.repeat(call, timer=time.thread_time, repeat=rounds, number=count)
        times_s = [round_s / count for round_s in rounds_s]
    if not np.isfinite(end).all():
        raise ArithmeticError("the end state is not finite")
    time_s = statistics.median(times_s) / problem.scene.duration_s
    return problem.error(end, reference(problem)[0]), time_s


def measure(quick: bool, tell: Callable[[str], None]) -> Iterator[Row]:
    """Yield a row for each method and setting; after an overrun, finer settings are not tried.

    After a fixed step that was refused as too long, they are. tell: called with a line of progress.
    """
    limit_s, rounds, computer = (3.0, 3, machine()) if quick else (1.0, 5, machine())
    with Limited() as child:
        for problem in problems():
            if quick > problem.quick:
                continue
            tell(f"error against run time: {problem.title} ...")
            for name, kind, values in contenders(problem):
                overran = ""
                settings = values
                if quick:  # every other setting; of SciPy's solvers the best one at two
                    best = values[:3:2] if name == f"{PEER}DOP853" else ()
                    settings = values[::2] if name in METHODS else best
                for setting in settings:
                    work, answer, note = (name, kind, setting), None, overran
                    if not overran:
                        answer, note = child(limit_s, _timed, problem, work, rounds)
                        if note.startswith(("HANG", "CRASH")):
                            overran = f"not tried: {note} at the setting before"
                    error, time_s = answer or (math.nan, math.nan)
                    yield Row(problem.name, *work, error, time_s, note, computer)


def time_at(error: float, rows: Sequence[Row]) -> float:
    """Return the time at which a method reaches an error, inf if it never does.

    It is interpolated between the settings of rows, in logarithms.
    """
    reached = sorted((max(row.error, 1e-300), row.time_s) for row in rows if row.error >= 0)
    if not reached or reached[0][0] > error:
        return math.inf
    errors, times = np.log(reached).T
    return math.exp(np.interp(math.log(error), errors, np.minimum.accumulate(times)))


def table(rows: Sequence[Row]) -> str:
    """Return a Markdown table: processor time, ms, of a simulated second at an error of 1e-6."""
    lines: dict[tuple[str, str], list[Row]] = {}
    for row in sorted(rows, key=lambda row: PEER in row.method):
        lines.setdefault((row.method, row.scene), []).append(row)
    times_ms = {key: 1e3 * time_at(1e-6, points) for key, points in lines.items()}
    scenes = dict.fromkeys(row.scene for row in rows)

    def best(scene: str, peer: bool) -> float:
        keys = [key for key in times_ms if key[1] == scene and (PEER in key[0]) == peer]
        return min((times_ms[key] for key in keys), default=math.inf)

    def cell(value: float | None) -> str:
        if value is None:
            return ""
        return f"{float(f'{value:.2g}'):g}" if math.isfinite(value) else "–"

    cells = [["ms", *scenes], ["---", *("---:" for _ in scenes)]]
    for name in dict.fromkeys(name for name, _ in lines):
        cells.append([name, *(cell(times_ms.get((name, scene))) for scene in scenes)])
    ratios = [cell(best(scene, True) / best(scene, False)) for scene in scenes]
    cells.append(["SciPy's best / our best", *ratios])
    return "\n".join("| " + " | ".join(line) + " |" for line in cells)


def machine() -> str:
    """Return the names of processor and compiler, on which times depend."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        lines = []
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return f"{names[0] if names else platform.machine()}, {_core.compiler}, one core"
