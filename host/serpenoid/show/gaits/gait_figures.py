"""Pictures of gaits: the cliff, the cloud of gaits with its front, optima against speed, maps."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ...gaits.finder import LeastPower
from ...gaits.margins import Cliff, cliff_around
from ...gaits.uncertainty import Uncertainty
from ...model.gait import Gait
from ...model.ground import Ground
from ...model.robot import Robot
from ...periodic.sweep import Sweep
from ..figure_data import write_columns
from ..plot import BLUE, GREY, ORANGE, columns, figure, gait_title, heading, robot_words

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def cliff_figure(
    robot: Robot, ground: Ground, gait: Gait, uncertainty: Uncertainty, path: Path
) -> None:
    """Draw speed against amplitude and grip around a gait, with its doubt and the edge.

    Its numbers go into a CSV file beside the picture.
    """
    cliff = cliff_around(robot, ground, gait, uncertainty)
    with figure(6.4, 5.2, path=path) as (fig, ax):
        _draw_cliff(fig, ax, cliff)
        fig.suptitle(robot_words(robot, ground), fontsize=8, color=GREY)
    amplitude, factor = np.meshgrid(cliff.amplitude, cliff.factor, indexing="ij")
    names = "amplitude_factor", f"{cliff.grip}_factor", "speed_m_s"
    write_columns(path, dict(zip(names, (amplitude, factor, cliff.speed_m_s), strict=True)))


def _draw_cliff(fig: Any, ax: Axes, cliff: Cliff) -> None:
    from matplotlib.patches import Ellipse

    x, y = 100 * (cliff.amplitude - 1), 100 * (cliff.factor - 1)
    ratio = 100 * cliff.speed_m_s.T / cliff.full_m_s
    levels = np.arange(0, 141, 10)
    shade = ax.contourf(x, y, ratio, levels=levels, cmap="cividis", extend="max")
    fig.colorbar(shade, ax=ax, label="speed (% of the gait's)")
    edge = ax.contour(x, y, ratio, levels=[90], colors="white", linewidths=2)
    ax.clabel(edge, fmt=lambda _: "90 %", fontsize=8)
    for k, style in ((1, "-"), (2, "--")):
        width, height = (200 * k * s for s in cliff.sigma)
        ax.add_patch(Ellipse((0, 0), width, height, fill=False, ec="black", ls=style, lw=1.5))
    ax.plot(0, 0, "o", color="black", mec="white", ms=7)
    ax.text(
        0.98,
        0.02,
        "dot: the gait; ellipses: 1σ and 2σ\nthick line: a tenth of the speed is lost",
        transform=ax.transAxes,
        ha="right",
        va="bottom",
        fontsize=8,
        color="white",
    )
    ax.set(
        xlabel="amplitude of the joints, off by (%)",
        ylabel=f"{cliff.grip}, off by (%)",
        xlim=(x[0], x[-1]),
        ylim=(y[0], y[-1]),
    )
    ax.set_title(f"{gait_title(cliff.gait)}: {cliff.full_m_s:.3g} m/s", fontsize=10)
    ax.grid(visible=False)


def optimum_figure(
    best: Sequence[LeastPower],
    papers: dict[str, float],
    title: str,
    path: Path,
    amplitudes_deg: Sequence[float],
    along: Sequence[float],
) -> None:
    """Draw the optimum's rate, lag and amplitude against speed (Figs. 9, 10, 11).

    papers: what the paper states for "beta_deg" and "alpha_deg", drawn as dashed lines.
    amplitudes_deg: as they are to be counted; along: what part of each speed counts.
    """
    speed = [b.speed_m_s * part for b, part in zip(best, along, strict=True)]
    omega_rad_s, beta_rad = columns([b.gait for b in best], "omega_rad_s", "beta_rad")
    optimum = {
        "omega_rad_s": omega_rad_s,
        "beta_deg": np.degrees(beta_rad),
        "alpha_deg": np.array(amplitudes_deg),
    }
    words = (
        ("rate (Fig. 9)", "ω (rad/s)"),
        ("phase lag (Fig. 10)", "β (°)"),
        ("amplitude (Fig. 11)", "α (°)"),
    )
    with figure(10.5, 3.8, 3, path=path) as (fig, axes):
        for ax, (name, unit), (key, values) in zip(axes, words, optimum.items(), strict=True):
            stated = papers.get(key)
            ax.plot(speed, values, "o-", color=BLUE, ms=4, label="least power")
            if stated is not None:
                ax.axhline(
                    stated, color=ORANGE, ls="--", label=f"the paper: {stated:g}° at every speed"
                )
                # as far about the claim as any optimum lies, and half of that more
                reach = max(10.0, 1.5 * float(np.abs(values - stated).max()))
                ax.set_ylim(stated - reach, stated + reach)
            else:
                slope = float(np.dot(speed, values) / np.dot(speed, speed))
                ax.plot(
                    [0, speed[-1]],
                    [0, slope * speed[-1]],
                    "--",
                    color=ORANGE,
                    label="the paper: nearly linear",
                )
                ax.set_ylim(0, 1.25 * max(values))
            ax.set(xlabel="speed (m/s)", ylabel=unit, title=name)
            ax.set_xlim(left=0)
            ax.yaxis.get_major_locator().set_params(steps=[1, 2, 5, 10])
            ax.legend(loc="upper left", fontsize=8)
        heading(fig, title)
    write_columns(path, {"speed_m_s": speed} | optimum)


def shape_maps(found: Sweep, at: int, title: str, path: Path) -> None:
    """Draw heat maps of speed and of power per speed over (alpha, beta) at one rate of a sweep."""
    from matplotlib.colors import LogNorm
    from matplotlib.ticker import LogLocator, MaxNLocator

    speed, power = found.speed_m_s[:, :, at], found.power_w[:, :, at]
    with np.errstate(divide="ignore", invalid="ignore"):
        cost = np.where(speed > 0.02 * speed.max(), power / speed, np.nan)
    alpha, beta = np.degrees(found.alpha_rad), np.degrees(found.beta_rad)
    parts = (("speed (m/s)", speed), ("net power over speed (N)", cost))
    least = float(np.nanmin(cost))
    scales = (
        (MaxNLocator(14).tick_values(0, float(speed.max())), None, MaxNLocator(5)),
        (least * np.geomspace(1, 16, 17), LogNorm(), LogLocator(subs=(1, 2, 5))),
    )
    with figure(9.6, 4.0, 2, path=path) as (fig, axes):
        for ax, (name, values), (levels, norm, ticks) in zip(axes, parts, scales, strict=True):
            past = np.nanmax(values) > levels[-1]
            shade = ax.contourf(
                alpha,
                beta,
                values.T,
                levels,
                cmap="cividis",
                norm=norm,
                extend="max" if past else "neither",
            )
            fig.colorbar(shade, ax=ax, ticks=ticks, format="%g").minorticks_off()
            ax.set(xlabel="amplitude α (°)", ylabel="phase lag β (°)", title=name)
            ax.grid(visible=False)
        fig.suptitle(title, fontsize=9, color=GREY)
    grid = dict(
        zip(("alpha_deg", "beta_deg"), np.meshgrid(alpha, beta, indexing="ij"), strict=True)
    )
    write_columns(path, grid | {"speed_m_s": speed, "power_w": power})
