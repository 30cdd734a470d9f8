"""Every picture the program draws, in one style; SI inside, degrees and Hz on the axes."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base.files import whole_file
from ..friction.paper_fit import friction_points, point_errors
from ..friction.result import FrictionFit
from ..model.ground import Ground
from ..model.robot import Robot
from ..session.session import Session
from ..simulation.run import Run

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


# Okabe and Ito's colours, which colour-blind readers can tell apart.
BLUE, ORANGE, GREEN, RED, GREY = "#0072B2", "#E69F00", "#009E73", "#D55E00", "#555555"
COLOURS = (BLUE, ORANGE, GREEN, RED, "#CC79A7", "#56B4E9", "#8B6914", GREY)  # Of curves, in order.


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
    import matplotlib as mpl
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

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
    }
    with mpl.rc_context(style):
        drawn = Figure(figsize=(width_in, height_in))
        FigureCanvasAgg(drawn)
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


def draw_links(ax: Axes, run: Run, index: int, lift_m: float, colour: Any) -> None:
    """Draw the links of one recorded state as sticks, lifted, with a dot on the head."""
    x, y, angle = run.x_m[index], run.y_m[index] + lift_m, run.theta_rad[index]
    ends = np.outer([-0.5, 0.5], run.scene.robot.link_length_m * np.exp(1j * angle)) + x + 1j * y
    ax.plot(ends.real, ends.imag, color=colour, lw=3.2, solid_capstyle="round")
    ax.plot(ends[-1, -1].real, ends[-1, -1].imag, "o", color=colour, ms=6)


def draw_path(ax: Axes, run: Run) -> None:
    """Draw the paths of tail, head and centre of mass, with a key above them."""
    ax.plot(run.x_m[:, 0], run.y_m[:, 0], color=ORANGE, lw=1.0, label="tail")
    ax.plot(run.x_m[:, -1], run.y_m[:, -1], color=BLUE, lw=1.0, label="head")
    ax.plot(*run.centre_m.T, color="black", lw=2.0, label="centre of mass")
    ax.plot(0, 0, "o", mfc="white", mec="black", ms=7, zorder=5, label="start")
    ax.legend(loc="lower left", bbox_to_anchor=(-0.01, 0.985), ncols=4)


def along_travel(run: Run) -> Run:
    """Turn a run so that it travels along x and starts at the origin."""
    x, y = run.centre_m.T
    turn = np.exp(-1j * np.arctan2(y[-1] - y[0], x[-1] - x[0]))
    place = turn * (run.x_m - x[0] + 1j * (run.y_m - y[0]))
    velocity = turn * (run.vx_m_s + 1j * run.vy_m_s)
    return replace(
        run,
        x_m=place.real,
        y_m=place.imag,
        theta_rad=run.theta_rad + np.angle(turn),
        vx_m_s=velocity.real,
        vy_m_s=velocity.imag,
    )


def path_and_poses(run: Run, title: str, path: Path) -> None:
    """Draw the path of head, tail and centre of mass (Fig. 12) and six poses (Fig. 13)."""
    run = along_travel(run)
    period_s, t_s = run.scene.gait.period_s, run.t_s
    with figure(9.0, 6.0, rows=2, path=path, height_ratios=[1, 1.9]) as (fig, (top, bottom)):
        draw_path(top, run)
        top.set(xlabel="x (m)", ylabel="y (m)")
        top.set_aspect(3)
        top.set_title(f"{t_s[-1] / period_s:.0f} cycles, y enlarged three times (Fig. 12)", pad=22)
        spacing = 1.15 * float(np.ptp(run.y_m[t_s < period_s]))
        for k, colour in enumerate(COLOURS[:6]):
            index = int(np.abs(t_s - k * period_s / 6).argmin())
            draw_links(bottom, run, index, -k * spacing, colour)
        bottom.set(
            title="poses of one cycle at 0, T/6 ... 5T/6, set apart downwards; the dot is the head "
            "(Fig. 13)",
            xlabel="x, along the mean direction of travel (m)",
            yticks=[],
            aspect="equal",
        )
        heading(fig, f"{title}: {robot_words(run.scene.robot, run.scene.ground)}", 10)


def robot_words(robot: Robot, ground: Ground) -> str:
    """Return the whole robot and its friction for a title."""

    def ends(along: float | tuple[float, float]) -> str:
        return "/".join(f"{value:.3g}" for value in np.atleast_1d(along))

    ground_of_body = ground.scaled(*4 * [robot.links])
    friction = f"ct {ends(ground_of_body.ct)}, cn {ground_of_body.cn:.3g} N s/m"
    if ground.dry:
        friction += f", ft0 {ends(ground_of_body.ft0)}, fn0 {ground_of_body.fn0:.3g} N"
    return f"{robot.links} links of {robot.link_length_m:g} m, {robot.mass_kg:.4g} kg; {friction}"
