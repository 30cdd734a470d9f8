"""Draws the work-precision diagrams: error against run time, one panel a scene."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...show.plot import GREY, figure
from .. import machine
from ..problems import problems
from ..reference import reference
from .equal_error import lines, ours_first
from .measure import Row

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# colour by family, ours in strong ones; the marker tells the members apart
OURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000", "#882255")
PEERS = {"SciPy": "#a9a9a9", "SUNDIALS": "#9384b8", "Numba": "#6f8f6f", "MuJoCo": "#c9a96a"}
MARKERS = "osD^vP*X"


def _style(methods: Sequence[Row]) -> dict[str, dict[str, Any]]:
    """Return how each contender is drawn, the same in all panels; ours come first."""
    styles: dict[str, dict[str, Any]] = {}
    count: dict[str, int] = {}
    for row in methods:
        if row.method in styles:
            continue
        k = count.setdefault(row.family, 0)
        count[row.family] += 1
        marker = MARKERS[k % len(MARKERS)]
        if row.family in PEERS:
            look = {"color": PEERS[row.family], "lw": 1.0, "ms": 4.5, "zorder": 2, "mfc": "white"}
        else:
            look = {"color": OURS[k % len(OURS)], "lw": 2.0, "ms": 5.5, "zorder": 3}
        styles[row.method] = {**look, "marker": marker}
    return styles


def _panel(ax: Axes, rows: Sequence[Row], scene: str, styles: dict[str, dict[str, Any]]) -> None:
    problem = next(p for p in problems() if p.name == scene)
    for method, line in lines(rows, scene).items():
        points = [(r.error, r.time_s / r.simulated_s) for r in line
                  if r.error is not None and r.time_s is not None and r.error < 10]  # fmt: skip
        if points:
            error, seconds = zip(*points, strict=True)
            ax.loglog(error, seconds, **styles[method])
    known = reference(problem).known_to
    ax.axvspan(1e-16, known, color="#eeeeee", lw=0)
    ax.set(title=problem.title, xlim=(min(1e-13, known / 3), 3))
    ax.invert_xaxis()


def accuracy_figure(rows: Sequence[Row], path: Path) -> None:
    """Draw every scene that was measured, more accurate to the right, faster below."""
    from matplotlib.lines import Line2D

    scenes = list(dict.fromkeys(row.scene for row in rows))
    columns = min(3, len(scenes))
    down = -(-len(scenes) // columns)
    styles = _style(ours_first(rows))
    with figure(4.2 * columns, 3.3 * down + 1.5) as (fig, _unused):
        fig.clear()
        axes = fig.subplots(down, columns, squeeze=False)
        for ax, scene in zip(axes.flat, scenes, strict=False):
            _panel(ax, rows, scene, styles)
        for ax in axes.flat[len(scenes) :]:
            ax.set_axis_off()
        for ax in axes[-1]:
            ax.set_xlabel("scaled error of the end state")
        for ax in axes[:, 0]:
            ax.set_ylabel("processor time (s)\nper simulated second")
        handles = [Line2D([], [], label=name, **look) for name, look in styles.items()]
        fig.legend(handles=handles, loc="outside lower center", ncols=min(6, 2 * columns),
                   fontsize=9)  # fmt: skip
        fig.suptitle(
            "Filled: this package; open: what else one might take. Lower is faster, right is more "
            f"accurate;\ngrey edge: the reference is not known better. {machine.cpu()}, "
            f"{machine.compiler()}, one core", fontsize=9, color=GREY, ha="left", x=0.01,
        )  # fmt: skip
        fig.savefig(path, dpi=120)
