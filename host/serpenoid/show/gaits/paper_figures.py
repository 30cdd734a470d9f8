"""Figures of the 2005 paper that no other command draws: errors in time, power against speed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ...periodic.sweep import Sweep
from ..plot import BLUE, GREY, RED, figure
from ..report import write_csv
from .gait_figures import beside

if TYPE_CHECKING:
    from ...gaits.least_power import LeastPower
    from ...gaits.paper_study import Comparison


def errors_in_time(found: Comparison, path: Path) -> None:
    """Draw how far the implicit model is off the exact one in time (Figs. 6 and 7)."""
    speed = np.hypot(*found.velocity_error_m_s.T)
    with figure(9.6, 3.6, 2) as (fig, (left, right)):
        left.plot(found.t_s, 1e3 * found.theta_error_rad, color=BLUE, lw=1.2)
        left.set(xlabel="t (s)", ylabel="1e-3 rad", title="angle of the tail (Fig. 6)")
        right.semilogy(found.t_s, np.maximum(speed, 1e-9), color=RED, lw=1.0)
        right.set(xlabel="t (s)", ylabel="m/s", title="velocity of the tail (Fig. 7)")
        fig.suptitle(
            "three links, α = 30°, β = 90°, ω = 3 rad/s; k = 1000 N/m, c = 1 N s/m, RK4 of 1 ms",
            fontsize=9, color=GREY,
        )  # fmt: skip
        fig.savefig(path)
    rows = np.column_stack([found.t_s, found.theta_error_rad, found.velocity_error_m_s]).tolist()
    header = ["t_s", "theta_error_rad", "vx_error_m_s", "vy_error_m_s"]
    write_csv(beside(path), header, rows)


def power_of(
    cloud: Sweep, front: Sequence[LeastPower], along: Sequence[float], cost: str, title: str,
    path: Path,
) -> None:  # fmt: skip
    """Draw the power of all gaits against speed, and the least (Fig. 8).

    along: what part of each optimum's speed counts. cost: a power's name.
    """
    watts = getattr(cloud, f"{cost}_w")
    good = cloud.converged & (cloud.speed_m_s > 1e-3)
    speed = [b.speed_m_s * part for b, part in zip(front, along, strict=True)]
    with figure(7.2, 4.8) as (fig, ax):
        ax.scatter(cloud.speed_m_s[good], watts[good], s=2, color="#b0b0b0", lw=0,
                   rasterized=True, label=f"{int(good.sum())} gaits of the grid")  # fmt: skip
        ax.plot(speed, [b.power_w for b in front], "o-", color=BLUE, ms=4, label="least power")
        ax.set(xlabel="speed (m/s)", ylabel="power (W)", xscale="log", yscale="log",
               title=f"{title} (Fig. 8)")  # fmt: skip
        ax.legend(loc="upper left")
        fig.savefig(path)
    rows = [
        [v, b.power_w, math.degrees(b.gait.alpha_rad), math.degrees(b.gait.beta_rad),
         b.gait.omega_rad_s]
        for v, b in zip(speed, front, strict=True)
    ]  # fmt: skip
    header = ["speed_m_s", f"{cost}_w", "alpha_deg", "beta_deg", "omega_rad_s"]
    write_csv(beside(path), header, rows)
