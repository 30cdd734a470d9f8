"""Work-precision diagrams: error against run time, one panel a scene."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain
from pathlib import Path
from typing import Any

from ..show.plot import figure, heading
from ..simulation.scene import METHODS
from .problems import problems, reference
from .work_precision import Points, Row, points_of

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#B8860B")  # of our methods, in order
MARKERS = "osD^v"
SCIPY = "SciPy's best"
ERRORS, TIMES_S = (3.0, 1e-15), (3e-6, 5.0)  # the same in all panels
WORDS = (
    "Filled: this package; open: the best of SciPy's solvers, on equations in Python. Lower is "
    "faster, right is more accurate.\nGrey: the reference is not known better. "
)


def _front(points: Points) -> Points:
    """Return those points than which none is both more accurate and faster."""
    best: Points = []
    for error, seconds in sorted(points):
        if not best or seconds < best[-1][1]:
            best.append((error, seconds))
    return best


def series(rows: Sequence[Row], scene: str) -> dict[str, Points]:
    """Return (error, time) of each method of ours, and the front of SciPy's."""
    lines = {
        name: [point for point in points if point[0] < ERRORS[0]]
        for name, points in points_of(rows, scene).items()
    }
    ours = {name: lines[name] for name in METHODS if lines.get(name)}
    theirs = chain.from_iterable(lines[name] for name in lines if name not in METHODS)
    return ours | {SCIPY: _front(list(theirs))}


def work_precision_figure(rows: Sequence[Row], path: Path, machine: str) -> None:
    """Draw every scene that was measured, more accurate to the right, faster below."""
    scenes = [p for p in problems() if any(row.scene == p.name for row in rows)]
    columns = min(3, len(scenes))
    row_count = -(-len(scenes) // columns)
    styles: dict[str, Any] = {
        name: {"color": colour, "marker": marker, "lw": 1.8, "ms": 4.5, "zorder": 3}
        for name, colour, marker in zip(METHODS, COLOURS, MARKERS, strict=True)
    }
    styles[SCIPY] = {"color": "#8c8c8c", "marker": "o", "mfc": "white", "lw": 1.2, "ms": 4}
    panels = {"rows": row_count, "squeeze": False, "sharex": True, "sharey": True}
    with figure(4.2 * columns, 3.4 * row_count + 1.2, columns, path=path, **panels) as (fig, axes):
        for ax, problem in zip(axes.flat, scenes, strict=False):
            for name, points in series(rows, problem.name).items():
                ax.loglog(*(zip(*points, strict=True) if points else ((), ())), **styles[name])
            ax.axvspan(ERRORS[1], reference(problem).known_to, color="#eeeeee", lw=0)
            ax.set(title=problem.title, xlim=ERRORS, ylim=TIMES_S)
        for ax in axes.flat[len(scenes) :]:
            ax.set_axis_off()
        first = axes[0, 0]
        handles = [first.plot([], [], label=name, **style)[0] for name, style in styles.items()]
        fig.legend(handles=handles, loc="outside lower center", ncols=2 * columns)
        for ax in axes[-1]:
            ax.set_xlabel("scaled error of the end state")
        fig.supylabel("processor time (s) per simulated second", fontsize=10)
        heading(fig, f"{WORDS}{machine}")
