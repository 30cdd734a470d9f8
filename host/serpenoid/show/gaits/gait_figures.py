"""Figures of the 2005 paper about gaits of least power, and about its two models."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from ...base.vectors import columns
from ...gaits.least_power import LeastPower
from ...paper.study import Comparison
from ...periodic.sweep import Sweep
from ..plot import (
    BLUE,
    ORANGE,
    RED,
    figure,
    heading,
)


def optimum_figure(best: Sequence[LeastPower], title: str, path: Path) -> None:
    """Draw the optimum's rate, lag and amplitude against speed (Figs. 9, 10, 11)."""
    speed = np.array([b.speed_m_s for b in best])
    omega, beta, alpha = columns([b.gait for b in best], "omega_rad_s", "beta_rad", "alpha_rad")
    linear = speed * (speed @ omega) / (speed @ speed)
    panels = (
        ("rate (Fig. 9)", "ω (rad/s)", omega, linear, "nearly linear"),
        ("phase lag (Fig. 10)", "β (°)", np.degrees(beta), 80 + 0 * speed, "80° at every speed"),
        ("amplitude (Fig. 11)", "α (°)", np.degrees(alpha), 30 + 0 * speed, "30° at every speed"),
    )
    with figure(10.5, 3.8, 3, path=path) as (fig, axes):
        for ax, (name, unit, values, stated, words) in zip(axes, panels, strict=True):
            ax.plot(speed, values, "o-", color=BLUE, ms=4, label="least power")
            ax.plot(speed, stated, "--", color=ORANGE, label=f"the paper: {words}")
            ax.set(xlabel="speed (m/s)", ylabel=unit, title=name)
            ax.set(xlim=(0, None), ylim=(0, 1.3 * values.max()))  # room for the legend
            ax.legend(loc="upper left")
        heading(fig, title)


def errors_in_time(closed: Comparison, opened: Comparison, path: Path) -> None:
    """Draw how far the implicit model is off the exact one in time (Figs. 6 and 7)."""
    with figure(9.6, 4.2, 2, path=path) as (fig, (angle_axis, right)):
        for errors, colour, style, name in (
            (closed, RED, "-", "all gaps closed at first (the paper)"),
            (opened, BLUE, "--", "gaps opened by the forces at first"),
        ):
            angle = 1e3 * errors.angle_rad
            angle_axis.plot(errors.t_s, angle, style, color=colour, lw=1.0, label=name)
            size = np.maximum(errors.velocity_m_s, 1e-6)
            right.semilogy(errors.t_s, size, style, color=colour, lw=0.9)
        angle_axis.axhspan(-1, 1, color="#eeeeee", zorder=0, label="1 mrad, the paper's order")
        angle_axis.set(title="tail's angle (Fig. 6)", ylabel="error of the angle (mrad)")
        right.set(title="tail's velocity (Fig. 7)", ylabel="error of the velocity, its size (m/s)")
        for ax, ends in ((angle_axis, (-1.5, 2.6)), (right, (3e-5, 5e-2))):
            ax.set(xlabel="time (s)", xlim=(0, closed.t_s[-1]), ylim=ends)
        angle_axis.legend(loc="upper right")
        heading(
            fig,
            "implicit less exact model: three links of 1 kg, 0.12 m; α = 30°, β = 90°, "
            "ω = 3 rad/s;\nk = 1000 N/m, c = 1 N s/m, RK4 of 1 ms",
        )


def power_of(
    cloud: Sweep,
    front: Sequence[LeastPower],
    title: str,
    path: Path | None,
) -> Figure:
    """Draw the power of all gaits against speed, and the least (Fig. 8)."""
    watts, least_m_s = cloud.power_w, 1e-3  # below this speed a gait stays where it is
    travels = cloud.converged & (cloud.speed_m_s > least_m_s) & (watts > 0)
    speed = [b.speed_m_s for b in front]
    with figure(7.2, 5.0, path=path) as (fig, ax):
        words = f"{int(travels.sum())} gaits that travel"
        look = {"color": "#9a9a9a", "ms": 2, "mew": 0, "rasterized": True}
        ax.plot(cloud.speed_m_s[travels], watts[travels], "o", label=words, **look)
        ax.set(xlabel="speed (m/s)", ylabel="power (W)", xscale="log", yscale="log")
        if speed:  # the claim is about the front: what is far slower only shrinks it
            ax.plot(speed, [b.power_w for b in front], "o-", color=BLUE, ms=4, label="least power")
            ax.set_xlim(left=0.5 * min(speed))
        ax.legend(loc="upper left")
        heading(fig, title)
        return fig
