"""Error against run time of every method and of SciPy's solvers, on scenes of both models.

Times are processor time of the thread that solves, medians, a simulated second. A run that fails,
overruns its limit or leaves the finite numbers is a row with the reason. An error is of the end
state, scaled, against a reference of the same model: what the springs of the implicit model err is
not in it.
"""

from __future__ import annotations

import dataclasses
import math
import platform
import statistics
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from .. import _core
from ..base.files import csv_rows, read_text, write_csv
from ..simulation.scene import METHODS, objection
from ..simulation.simulate import simulate
from . import scipy_peer
from .child_process import Limited
from .problems import Array, Problem, problems, reference

STEPS_S = (1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5)
TOLERANCES = (1e-3, 1e-5, 1e-7, 1e-9, 1e-11)
WIDTHS_M_S = (1e-2, 3e-3, 1e-3, 1e-4, 1e-5, 1e-6)  # Widths of the smoothed sign
DRY_TOLERANCE = 1e-7  # with a smoothed sign: finer than what the widths leave
MIN_TIMED_S = 2e-3  # shorter work is repeated within a round
MAX_TIMED_S = 0.1  # longer work is timed once
TABLE_ERROR = 1e-6
PEER = "SciPy "  # begins the names of its methods
FAILED = math.nan, math.nan
Work = Callable[[], Array]
Points = list[tuple[float, float]]


@dataclass(frozen=True, slots=True)
class Row:
    """Hold what one method did at one setting; error and time are nan where it failed.

    kind: of the setting, "dt_s", "tolerance" or "width_m_s". time_s: for a simulated second.
    """

    scene: str
    method: str
    kind: str
    setting: float
    error: float = math.nan
    time_s: float = math.nan
    note: str = ""


class Contender(NamedTuple):
    """One way to solve a problem: the method, what its settings are, and their values."""

    name: str
    kind: str
    settings: tuple[float, ...]


def contenders(problem: Problem) -> list[Contender]:
    """Return every method of ours, and SciPy's; on dry ground the width of the sign is theirs."""
    scene, ways = problem.scene, []
    for name, kind in METHODS.items():
        if objection(name, scene) is None:
            adaptive = scene.formulation in kind.adaptive
            setting = ("tolerance", TOLERANCES) if adaptive else ("dt_s", STEPS_S)
            ways.append(Contender(name, *setting))
    dry = scene.law == "dry"
    setting = ("width_m_s", WIDTHS_M_S) if dry else ("tolerance", TOLERANCES)
    return ways + [Contender(PEER + name, *setting) for name in scipy_peer.METHODS]


def work_of(problem: Problem, method: str, kind: str, setting: float) -> Work:
    """Return the call that is timed, of one method at one setting; it returns the end state."""
    if method.startswith(PEER):
        how = (DRY_TOLERANCE, setting) if kind == "width_m_s" else (setting,)
        return partial(scipy_peer.solve, problem, method.removeprefix(PEER), *how)
    scene = problem.scene
    if kind == "dt_s":  # the duration is a whole number of steps
        setting = scene.duration_s / max(1, round(scene.duration_s / setting))
    changes: dict[str, Any] = {"method": method, "start": problem.start, kind: setting}
    scene = replace(scene, record_every=10**9, **changes)
    return lambda: problem.vector(simulate(scene).state())


@np.errstate(all="ignore")  # what overflows in SciPy ends as a row
def _timed(problem: Problem, work: tuple[str, str, float], rounds: int) -> tuple[float, float]:
    """Return the error and the time of a run: the median of rounds, or of one if it is long."""
    call = work_of(problem, *work)
    times, repeats, end = [], 1, np.empty(0)
    for number in range(rounds + 1):
        begin = time.thread_time()
        for _ in range(repeats):
            end = call()
        times.append((time.thread_time() - begin) / repeats)
        if number == 0:
            repeats = max(1, round(MIN_TIMED_S / max(times[0], 1e-7)))
            if times[0] > MAX_TIMED_S:
                break
    if not np.isfinite(end).all():
        raise ArithmeticError("the end state is not finite")
    median = statistics.median(times[1:] or times)
    return problem.error(end, reference(problem).end), median / problem.scene.duration_s


def measure(quick: bool, tell: Callable[[str], None]) -> Iterator[Row]:
    """Yield a row for each method and setting; past one that overran, tighter ones are not tried.

    A fixed step refused as too long does not end the row: a shorter one may be right.
    """
    limit_s, rounds = (3.0, 3) if quick else (1.0, 5)
    with Limited() as child:
        for problem in problems():
            if quick > problem.quick:
                continue
            tell(f"error against run time: {problem.title} ...")
            for name, kind, values in contenders(problem):
                settings, overran = values, ""
                if quick:  # every other setting; of SciPy's solvers the best one at two
                    best = values[:3:2] if name == f"{PEER}DOP853" else ()
                    settings = values[::2] if name in METHODS else best
                for setting in settings:
                    answer, note = None, overran
                    if not overran:
                        work = name, kind, setting
                        answer, note = child(limit_s, _timed, problem, work, rounds)
                        if note.startswith(("HANG", "CRASH")):
                            overran = f"not tried: {note} at the setting before"
                    error, time_s = answer or FAILED
                    yield Row(problem.name, name, kind, setting, error, time_s, note)


def time_at(error: float, points: Sequence[tuple[float, float]]) -> float | None:
    """Return the least time that reaches an error, or None where no setting does.

    points: (error, time), from the loosest setting to the tightest. Between a point above the
    error and the next one at or below it, time is interpolated along the straight line in log-log;
    nothing is extrapolated: a first point already good enough counts with its own time.
    """
    times = [points[0][1]] if points and points[0][0] <= error else []
    for (e0, t0), (e1, t1) in pairwise(points):
        if e0 > error >= e1:
            # an error of exactly 0 has no logarithm: the point itself is then the answer
            f = math.log(e0 / error) / math.log(e0 / e1) if e1 > 0 else 1.0
            times.append(t0 ** (1 - f) * t1**f)
        elif e1 <= error:
            times.append(t1)
    return min(times, default=None)


def points_of(rows: Sequence[Row], scene: str) -> dict[str, Points]:
    """Return (error, time) of a scene by method, without what failed."""
    points: dict[str, Points] = {row.method: [] for row in rows if row.scene == scene}
    for row in rows:
        if row.scene == scene and not math.isnan(row.error):
            points[row.method].append((row.error, row.time_s))
    return points


def table(rows: Sequence[Row]) -> str:
    """Return a Markdown table of ms of processor time a simulated second at TABLE_ERROR."""
    scenes = list(dict.fromkeys(row.scene for row in rows))
    times = [
        {name: time_at(TABLE_ERROR, line) for name, line in points_of(rows, scene).items()}
        for scene in scenes
    ]

    def cell(time_s: float | None) -> str:
        return (
            "–" if time_s is None else f"{1e3 * time_s:{'.2g' if time_s < MAX_TIMED_S else '.0f'}}"
        )

    methods = dict.fromkeys(row.method for row in sorted(rows, key=lambda r: PEER in r.method))
    lines = [["ms", *scenes], ["---", *("---:" for _ in scenes)]]
    lines += [[m, *(cell(column[m]) if m in column else "" for column in times)] for m in methods]
    last = ["**SciPy's best / our best**"]
    for column in times:
        theirs, ours = (
            min((t for m, t in column.items() if t and m.startswith(PEER) == peer), default=None)
            for peer in (True, False)
        )
        last.append(f"**{theirs / ours:.2g}**" if theirs and ours else "–")
    return "\n".join("| " + " | ".join(line) + " |" for line in [*lines, last])


def machine() -> str:
    """Return the processor and the compiler that a timing depends on."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        lines = []
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return f"{names[0] if names else platform.machine()}, {_core.compiler}, one core"


def write_rows(path: Path, rows: Sequence[Row]) -> None:
    """Write rows to a CSV file, each with the machine of the measurement."""
    header = [*(field.name for field in dataclasses.fields(Row)), "machine"]
    write_csv(path, header, [[*dataclasses.astuple(row), machine()] for row in rows])


def read_rows(path: Path) -> tuple[list[Row], str]:
    """Return the rows of a file that write_rows wrote, and the machine of the measurement."""
    _, *lines = csv_rows(read_text(path))
    numbers = [[float(cell or "nan") for cell in line[3:6]] for line in lines]
    rows = [
        Row(*line[:3], *values, line[6])  # type: ignore[arg-type]
        for line, values in zip(lines, numbers, strict=True)
    ]
    return rows, lines[0][7]
