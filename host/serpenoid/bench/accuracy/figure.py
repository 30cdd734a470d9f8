"""What the accuracy benchmark writes: rows, ratios at equal error, and the diagrams.

Work-precision diagrams: error against run time, one panel a scene.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ...base.files import write_text
from ...show.plot import figure, heading
from .. import machine
from ..problems import problems, reference
from ..rows import write_rows
from .equal_error import Points, headline, lines, ours_first
from .measure import Row

# ours one by one, in strong colours; of each family of peers the best that any of them does
OURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#B8860B", "#000000", "#882255", "#3A9BDC")
PEERS = {"SciPy": "#8c8c8c"}
MARKERS = "osD^vP*X"
ERRORS, TIMES = (3.0, 1e-15), (3e-6, 5.0)  # the same in all panels
WORDS = (
    "Filled: this package; open: the best of SciPy's solvers, on equations in Python. Lower is "
    "faster, right is more accurate.\nGrey: the reference is not known better. "
)


def series(rows: Sequence[Row], scene: str) -> dict[str, Points]:
    """Return (error, seconds) of each method of ours, and of each family of peers its front."""
    family = {row.method: row.family for row in rows}
    points: dict[str, Points] = {}
    for method, line in lines(rows, scene).items():
        name = family[method] if family[method] in PEERS else method
        points.setdefault(name, []).extend(p for p in line if p[0] < ERRORS[0])
    return {n: front(line) if n in PEERS else line for n, line in points.items() if line}


def front(points: Points) -> Points:
    """Return those points than which none is both more accurate and faster."""
    best: Points = []
    for error, seconds in sorted(points):
        if not best or seconds < best[-1][1]:
            best.append((error, seconds))
    return best


def accuracy_figure(rows: Sequence[Row], path: Path, where: str | None = None) -> None:
    """Draw every scene that was measured, more accurate to the right, faster below.

    where: the machine of the measurement, unless it is this one.
    """
    where = where or f"{machine.cpu()}, {machine.compiler()}, one core"
    scenes = list(dict.fromkeys(row.scene for row in rows))
    columns = min(3, len(scenes))
    down = -(-len(scenes) // columns)
    # each series looks the same in all panels; ours come first
    ours = dict.fromkeys(row.method for row in ours_first(rows) if row.family not in PEERS)
    strong = {"lw": 1.8, "ms": 4.5, "zorder": 3}
    open_circles = {"lw": 1.2, "ms": 4, "zorder": 2, "mfc": "white", "marker": "o"}
    looks = zip(ours, OURS, MARKERS, strict=False)
    styles: dict[str, Any] = {n: {"color": colour, "marker": m, **strong} for n, colour, m in looks}
    styles |= {name: {"color": colour, **open_circles} for name, colour in PEERS.items()}
    panels = {"rows": down, "squeeze": False, "sharex": True, "sharey": True}
    with figure(4.2 * columns, 3.4 * down + 1.2, columns, path=path, **panels) as (fig, axes):
        for ax, scene in zip(axes.flat, scenes, strict=False):
            problem = next(p for p in problems() if p.name == scene)
            for name, points in series(rows, scene).items():
                label = name.removeprefix("serpenoid ")
                ax.loglog(*zip(*points, strict=True), label=label, **styles[name])
            ax.axvspan(ERRORS[1], reference(problem).known_to, color="#eeeeee", lw=0)
            ax.set(title=problem.title, xlim=ERRORS, ylim=TIMES)
        for ax in axes.flat[len(scenes) :]:
            ax.set_axis_off()
        lines_by_name = {
            line.get_label(): line for ax in axes.flat[: len(scenes)] for line in ax.lines
        }
        fig.legend(
            lines_by_name.values(), lines_by_name, loc="outside lower center", ncols=2 * columns
        )
        for ax in axes[-1]:
            ax.set_xlabel("scaled error of the end state")
        fig.supylabel("processor time (s) per simulated second", fontsize=10)
        heading(fig, f"{WORDS}{where}")


def write_all(rows: Sequence[Row], out: Path) -> None:
    """Write accuracy.csv, .json and .png into a folder, with the machine of the measurement."""
    out.mkdir(parents=True, exist_ok=True)
    here = {"cpu": machine.cpu(), "compiler": machine.compiler()}
    measured = {row.scene for row in rows}
    content = {
        **here,
        "versions": machine.versions(),
        "references_known_to": {
            p.name: reference(p).known_to for p in problems() if p.name in measured
        },
        "headline": headline(rows),
    }
    write_rows(out / "accuracy.csv", rows, here)
    write_text(out / "accuracy.json", json.dumps(content, indent=1) + "\n")
    accuracy_figure(rows, out / "accuracy.png")
