"""Pictures of gaits: the cliff, the cloud of gaits with its front, optima against speed, maps."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...gaits.finder import LeastPower
from ...gaits.margins import Cliff, cliff_around
from ...gaits.uncertainty import Uncertainty
from ...model.files import write_csv
from ...model.gait import Gait
from ...model.ground import Ground
from ...model.robot import Robot
from ...periodic.sweep import Sweep
from ..figure_data import beside
from ..plot import BLUE, GREY, ORANGE, figure, robot_words, save

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]


def gait_words(gait: Gait) -> str:
    """Return a gait for a title."""
    return (
        f"α = {math.degrees(gait.alpha_rad):.1f}°, β = {math.degrees(gait.beta_rad):.1f}°, "
        f"ω = {gait.omega_rad_s:.3g} rad/s"
    )


def cliff_figure(
    robot: Robot, ground: Ground, gait: Gait, uncertainty: Uncertainty, path: Path
) -> None:
    """Draw speed against amplitude and grip around a gait, with its doubt and the edge."""
    draw_cliff(cliff_around(robot, ground, gait, uncertainty), path)


def draw_cliff(cliff: Cliff, path: Path, title: str = "") -> None:
    """Draw a cliff that was computed; its numbers go into a CSV file beside the picture."""
    with figure(6.4, 5.2) as (fig, ax):
        cliff_axes(fig, ax, cliff, title or gait_words(cliff.gait))
        fig.suptitle(robot_words(cliff.robot, cliff.ground), fontsize=8, color=GREY)
        save(fig, path)
    rows = [
        [a, f, cliff.speed_m_s[i, j]]
        for i, a in enumerate(cliff.amplitude.tolist())
        for j, f in enumerate(cliff.factor.tolist())
    ]
    write_csv(beside(path), ["amplitude_factor", f"{cliff.grip}_factor", "speed_m_s"], rows)


def cliff_axes(fig: Any, ax: Axes, cliff: Cliff, title: str) -> None:
    """Fill one pair of axes with a cliff."""
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
    ax.set(xlabel="amplitude of the joints, off by (%)", ylabel=f"{cliff.grip}, off by (%)")
    ax.set_xlim(x[0], x[-1])
    ax.set_ylim(y[0], y[-1])
    ax.set_title(f"{title}: {cliff.full_m_s:.3g} m/s", fontsize=10)
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
    parts = (
        ("rate (Fig. 9)", "ω (rad/s)", [b.gait.omega_rad_s for b in best], None),
        (
            "phase lag (Fig. 10)",
            "β (°)",
            [math.degrees(b.gait.beta_rad) for b in best],
            papers.get("beta_deg"),
        ),
        ("amplitude (Fig. 11)", "α (°)", list(amplitudes_deg), papers.get("alpha_deg")),
    )
    with figure(10.5, 3.8, 3) as (fig, axes):
        for ax, (name, unit, values, stated) in zip(axes, parts, strict=True):
            ax.plot(speed, values, "o-", color=BLUE, ms=4, label="least power")
            if stated is not None:
                ax.axhline(
                    stated, color=ORANGE, ls="--", label=f"the paper: {stated:g}° at every speed"
                )
                # as far about the claim as any optimum lies, and half of that more
                reach = max(10.0, 1.5 * max(abs(v - stated) for v in values))
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
        fig.suptitle(title, fontsize=9, color=GREY, x=0.01, ha="left")
        save(fig, path)
    rows = [list(row) for row in zip(speed, *[values for _, _, values, _ in parts], strict=True)]
    write_csv(beside(path), ["speed_m_s", "omega_rad_s", "beta_deg", "alpha_deg"], rows)


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
    with figure(9.6, 4.0, 2) as (fig, axes):
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
        save(fig, path)
    rows = [
        [a, b, speed[i, j], power[i, j]]
        for i, a in enumerate(alpha.tolist())
        for j, b in enumerate(beta.tolist())
    ]
    write_csv(beside(path), ["alpha_deg", "beta_deg", "speed_m_s", "power_w"], rows)
