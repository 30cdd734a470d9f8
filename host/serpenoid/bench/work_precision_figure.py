"""Draw work-precision diagrams: run time against error, one panel for each scene."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..show.plot import figure, heading
from ..simulation.scene import METHODS
from .problems import problems, reference
from .work_precision import PEER, Row


def work_precision_figure(rows: Sequence[Row], path: Path) -> None:
    """Draw all measured scenes; accuracy grows to the right, speed downwards."""
    measured = {row.scene for row in rows}
    scenes = [problem for problem in problems() if problem.name in measured]
    columns = min(3, len(scenes))
    row_count = -(-len(scenes) // columns)
    errors, times_s = (3.0, 1e-15), (3e-6, 5.0)  # Ends of the axes, the same in all panels.
    colours = "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#B8860B"
    styles: dict[str, Any] = {
        name: {"color": colour, "marker": marker, "lw": 1.8, "ms": 4.5, "zorder": 3}
        for name, colour, marker in zip(METHODS, colours, "osD^v", strict=True)
    }
    styles[PEER] = {"color": "#8c8c8c", "marker": "o", "mfc": "white", "lw": 0, "ms": 4}
    panels = {"rows": row_count, "squeeze": False, "sharex": True, "sharey": True}
    with figure(4.2 * columns, 3.4 * row_count + 1.2, columns, path=path, **panels) as (fig, axes):
        for ax, problem in zip(axes.flat, scenes, strict=False):
            shown = [row for row in rows if row.scene == problem.name and row.error < errors[0]]
            for name, style in styles.items():
                points = [(row.error, row.time_s) for row in shown if row.method.startswith(name)]
                ax.loglog(*np.reshape(points, (-1, 2)).T, **style)
            ax.axvspan(errors[1], reference(problem)[1], color="#eeeeee", lw=0)
            ax.set(title=problem.title, xlim=errors, ylim=times_s)
        for ax in axes.flat[len(scenes) :]:
            ax.set_axis_off()
        first = axes[0, 0]
        handles = [first.plot([], [], label=name, **style)[0] for name, style in styles.items()]
        fig.legend(handles=handles, loc="outside lower center", ncols=2 * columns)
        for ax in axes[-1]:
            ax.set_xlabel("scaled error of the end state")
        fig.supylabel("processor time (s) per simulated second", fontsize=10)
        heading(
            fig,
            "Filled: this package; open: SciPy's solvers, on equations in Python. Lower is faster, "
            "right is more accurate.\nGrey: below the error of the reference itself. "
            f"{rows[0].machine}",
        )
