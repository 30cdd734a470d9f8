"""Draws the work-precision diagrams: error against run time, one panel a scene."""

from __future__ import annotations

import math
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

# ours one by one, in strong colours; of each family of peers the best that any of them does
OURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#B8860B", "#000000", "#882255", "#3A9BDC")
PEERS = {"SciPy": "#8c8c8c", "SUNDIALS": "#7a68ad", "Numba": "#4f7a4f", "MuJoCo": "#a8813a"}
MARKERS = "osD^vP*X"
APART = 0.065  # of a panel's height, between two names
ERRORS, TIMES = (3.0, 1e-15), (3e-6, 5.0)  # the same in all panels
Points = list[tuple[float, float]]


def _styles(methods: Sequence[Row]) -> dict[str, dict[str, Any]]:
    """Return how each series is drawn, the same in all panels; ours come first."""
    styles: dict[str, dict[str, Any]] = {}
    for row in methods:
        k = len(styles)
        if row.family in PEERS:
            look = {"color": PEERS[row.family], "lw": 1.2, "ms": 4, "zorder": 2, "mfc": "white"}
            styles.setdefault(row.family, {**look, "marker": "o"})
        elif row.method not in styles:
            look = {"color": OURS[k % len(OURS)], "lw": 1.8, "ms": 4.5, "zorder": 3}
            styles[row.method] = {**look, "marker": MARKERS[k % len(MARKERS)]}
    return styles


def series(rows: Sequence[Row], scene: str) -> dict[str, Points]:
    """Return (error, seconds) of each method of ours, and of each family of peers its front."""
    found: dict[str, Points] = {}
    for method, line in lines(rows, scene).items():
        name = line[0].family if line and line[0].family in PEERS else method
        points = [
            (r.error, r.time_s / r.simulated_s)
            for r in line
            if r.error is not None and r.time_s is not None and r.error < ERRORS[0]
        ]
        found.setdefault(name, []).extend(points)
    return {
        name: front(points) if name in PEERS else points for name, points in found.items() if points
    }


def front(points: Points) -> Points:
    """Return those points than which none is both more accurate and faster."""
    best: Points = []
    for error, seconds in sorted(points):
        if not best or seconds < best[-1][1]:
            best.append((error, seconds))
    return best


def _panel(ax: Axes, rows: Sequence[Row], scene: str, styles: dict[str, dict[str, Any]]) -> None:
    problem = next(p for p in problems() if p.name == scene)
    ends: list[tuple[float, float, str]] = []
    for name, points in series(rows, scene).items():
        error, seconds = zip(*points, strict=True)
        ax.loglog(error, seconds, **styles[name])
        ends.append((*min(points), name))
    ax.axvspan(ERRORS[1], reference(problem).known_to, color="#eeeeee", lw=0)
    ax.set(title=problem.title, xlim=ERRORS, ylim=TIMES)
    _label(ax, ends, styles)


def _label(ax: Axes, ends: list[tuple[float, float, str]], styles: dict[str, Any]) -> None:
    """Write the names in a column beside the panel, each led to its line's most accurate point."""
    low, high = (math.log(t) for t in TIMES)
    ends = sorted(ends, key=lambda end: end[1])
    wanted = [(math.log(seconds) - low) / (high - low) for _, seconds, _ in ends]
    for (error, seconds, name), height in zip(ends, set_apart(wanted), strict=True):
        ax.annotate(
            name.removeprefix("serpenoid "),
            (error, seconds),
            xytext=(1.03, height),
            textcoords="axes fraction",
            va="center",
            fontsize=8,
            color=styles[name]["color"],
            annotation_clip=False,
            arrowprops={
                "arrowstyle": "-",
                "color": styles[name]["color"],
                "lw": 0.5,
                "alpha": 0.7,
                "shrinkA": 0,
                "shrinkB": 3,
            },
        )


def set_apart(wanted: Sequence[float]) -> list[float]:
    """Return rising places near those wanted, APART from one another, the last at most 1."""
    places: list[float] = []
    for place in wanted:
        places.append(max(place, places[-1] + APART) if places else place)
    for k in reversed(range(len(places))):
        above = 1.0 + APART if k + 1 == len(places) else places[k + 1]
        places[k] = min(places[k], above - APART)
    return places


def accuracy_figure(rows: Sequence[Row], path: Path, where: str | None = None) -> None:
    """Draw every scene that was measured, more accurate to the right, faster below.

    where: the machine of the measurement, unless it is this one.
    """
    where = where or f"{machine.cpu()}, {machine.compiler()}, one core"
    scenes = list(dict.fromkeys(row.scene for row in rows))
    columns = min(3, len(scenes))
    down = -(-len(scenes) // columns)
    styles = _styles(ours_first(rows))
    with figure(4.9 * columns, 3.4 * down + 0.9) as (fig, _unused):
        fig.clear()
        axes = fig.subplots(down, columns, squeeze=False, sharex=True, sharey=True)
        for ax, scene in zip(axes.flat, scenes, strict=False):
            _panel(ax, rows, scene, styles)
        for ax in axes.flat[len(scenes) :]:
            ax.set_axis_off()
        for ax in axes[-1]:
            ax.set_xlabel("scaled error of the end state")
        for ax in axes[:, 0]:
            ax.set_ylabel("processor time (s)\nper simulated second")
        fig.suptitle(
            "Filled: this package; open: the best of what else one might take. Lower is faster, "
            "right is more accurate.\nGrey: the reference is not known better. "
            f"{where}",
            fontsize=9,
            color=GREY,
            ha="left",
            x=0.01,
        )
        fig.savefig(path, dpi=120)
