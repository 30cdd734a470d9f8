"""Every picture the program draws, in one style; SI inside, degrees and Hz on the axes."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..base.files import whole_file
from ..friction.paper_fit import friction_points, point_errors
from ..friction.result import FrictionFit
from ..session.session import Session

# Okabe and Ito's colours, which colour-blind readers can tell apart.
BLUE, ORANGE, GREEN, RED, GREY = "#0072B2", "#E69F00", "#009E73", "#D55E00", "#555555"
COLOURS = (BLUE, ORANGE, GREEN, RED, "#CC79A7", "#56B4E9", "#8B6914", GREY)  # Colours of curves.


@contextmanager
def figure(
    width_in: float,
    height_in: float,
    columns: int = 1,
    rows: int = 1,
    path: Path | None = None,
    **grid: Any,
) -> Iterator[tuple[Figure, Any]]:
    """Give a figure and its axes in the house style, without a display.

    path: file that it is written into at the end, whole or not at all. grid: as for `subplots`.
    """
    style: Any = {
        "figure.dpi": 110,
        "savefig.dpi": 160,
        "figure.constrained_layout.use": True,
        "font.size": 10,
        "axes.titlesize": 11,
        "axes.titlelocation": "left",
        "axes.spines.top": False,
        "axes.spines.right": False,
        "axes.grid": True,
        "grid.color": "#e4e4e4",
        "grid.linewidth": 0.7,
        "axes.axisbelow": True,
        "lines.linewidth": 1.8,
        "legend.frameon": False,
        "legend.fontsize": 8,
        "svg.hashsalt": "serpenoid",  # Ids that are the same in each drawing
    }
    with mpl.rc_context(style):
        drawn = Figure(figsize=(width_in, height_in))
        yield drawn, drawn.subplots(rows, columns, **grid)
        if path is not None:
            with whole_file(path) as part:
                drawn.savefig(part)


def heading(fig: Figure, text: str, size: float = 9, colour: str = GREY) -> None:
    """Write a line above all axes, from the left."""
    fig.suptitle(text, fontsize=size, color=colour, x=0.01, ha="left")


def fit_heading(fig: Figure, fit: FrictionFit) -> None:
    """Write the session's name and how well the law fits it above all axes."""
    p_value = "" if fit.p_value is None else f", p = {fit.p_value:.2g}"
    words = f"$\\chi^2$ = {fit.chi2:.3g} for {fit.dof} dof{p_value}"
    heading(fig, f"{fit.session_name}: {words}", 10, "black")


def draw_friction(
    fig: Figure, axes: Any, fit: FrictionFit, session: Session | None, note: str = ""
) -> None:
    """Draw the fitted lines of the whole snake, and a session's readings."""
    lines = (
        ("straight", ("ct", "ft0"), "Along the links", BLUE),
        ("bent", ("cn", "fn0"), "Across the links", RED),
    )
    for ax, (part, names, title, colour) in zip(axes, lines, strict=True):
        axis, last_m_s = names[0][1], 1.0  # a fast belt, m/s
        if session is not None:
            speed, force = friction_points(session, fit)[part]
            last_m_s = 1.08 * float(speed.max())
            label = f"readings, {session.setup.provenance.kind}, ± 1 sigma"
            look = {"fmt": "o", "color": "black", "ms": 4, "lw": 0, "elinewidth": 1}
            errors = point_errors(session)[part]
            ax.errorbar(speed, force, *reversed(errors), label=label, zorder=3, **look)
            ax.legend(loc="lower right")
        slope, dry_n = (fit.parameters[name].value for name in names)
        rows = [list(fit.whole_snake).index(name) for name in names]
        v = np.linspace(0, last_m_s, 60)
        terms = np.column_stack([v, np.ones_like(v)])
        sigma = np.sqrt(np.sum(terms @ fit.covariance[np.ix_(rows, rows)] * terms, axis=1))
        law = slope * v + dry_n
        ax.fill_between(v, law - 1.96 * sigma, law + 1.96 * sigma, color=colour, alpha=0.18, lw=0)
        ax.plot(v, law, color=colour)
        words = f"$F_{axis} = {slope:.3g}\\,v_{axis} + {dry_n:.3g}$ N"
        ax.text(0.04, 0.95, words, transform=ax.transAxes, color=colour, va="top", fontsize=11)
        ax.set(title=title, xlim=(0, None), ylim=(0, None))
        ax.set_xlabel(f"speed $v_{axis}$ (m/s)")
        ax.set_ylabel(f"friction $F_{axis}$ of the whole snake (N)")
    fit_heading(fig, fit)
    words = "; ".join(filter(None, ["band: 95 % interval of the line", note]))
    fig.supxlabel(words, fontsize=8, color=GREY)


def formulations_figure(
    f: np.ndarray, exact: np.ndarray, implicit: np.ndarray, title: str, path: Path
) -> None:
    """Draw speeds, m/s, over rates, Hz, by the paper's two models (Fig. 17), and the difference."""
    with figure(8.4, 3.8, 2, path=path) as (fig, (speed_axis, right)):
        circles = {"mfc": "white", "color": ORANGE, "ms": 5.5, "mew": 1.5}
        speed_axis.plot(f, exact, color=BLUE, label="explicit (exact)")
        speed_axis.plot(f, implicit, "o", label="implicit, k = 1000 N/m, c = 1 N s/m", **circles)
        speed_axis.set(title="speed, ideal joints (Fig. 17)", ylabel="speed (m/s)")
        speed_axis.set(xlim=(0, None), ylim=(0, 1.4 * exact.max()))  # room for the legend
        speed_axis.legend(loc="upper left")
        right.axhline(0, color=BLUE)
        right.plot(f, 100 * (implicit / exact - 1), "o-", lw=1, **circles)
        right.set(title="implicit less explicit", ylabel="of the speed (%)", xlim=(0, None))
        for ax in (speed_axis, right):
            ax.set_xlabel("gait frequency (Hz)")
        heading(fig, title)


def hatch_beyond(ax: Axes, highest_hz: float | None, last_hz: float, servo: str) -> None:
    """Hatch the frequencies up to the last one that are too fast for a servo, named in words."""
    if highest_hz is None or highest_hz >= last_hz:
        return
    words = f"above {highest_hz:.2g} Hz too fast for {servo}"
    look = {"fc": "none", "ec": GREY, "alpha": 0.5, "hatch": "//", "zorder": 0, "lw": 0}
    ax.axvspan(highest_hz, last_hz, label=words, **look)
