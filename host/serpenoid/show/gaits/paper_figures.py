"""Figures of the 2005 paper that no other command draws: errors in time, power against speed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ...calibration.friction_fit import friction_points, point_errors
from ...model.files import write_csv
from ...periodic.sweep import Sweep
from ..figure_data import beside
from ..plot import BLUE, GREY, RED, along_travel, figure, save

if TYPE_CHECKING:
    from ...calibration.friction_result import FrictionFit
    from ...calibration.prediction import SpeedPoint
    from ...calibration.session import Session
    from ...gaits.finder import LeastPower
    from ...gaits.robust import RobustGait
    from ...paper.study import Comparison
    from ...simulation.run import Run


def errors_in_time(closed: Comparison, opened: Comparison, path: Path) -> None:
    """Draw how far the implicit model is off the exact one in time (Figs. 6 and 7)."""
    with figure(9.6, 4.2, 2) as (fig, (left, right)):
        for found, colour, style, name in (
            (closed, RED, "-", "all gaps closed at first (the paper)"),
            (opened, BLUE, "--", "gaps opened by the forces at first"),
        ):
            speed = np.hypot(*found.velocity_error_m_s.T)
            left.plot(
                found.t_s, 1e3 * found.theta_error_rad, style, color=colour, lw=1.0, label=name
            )
            right.semilogy(found.t_s, np.maximum(speed, 1e-6), style, color=colour, lw=0.9)
        left.axhspan(
            -1, 1, color="#eeeeee", zorder=0, label="1 mrad, the order that the paper tells"
        )
        left.set(
            xlabel="time (s)", ylabel="error of the angle (mrad)", title="tail's angle (Fig. 6)"
        )
        left.set_ylim(-1.5, 2.6)
        left.legend(loc="upper right", fontsize=8)
        right.set(
            xlabel="time (s)",
            ylabel="error of the velocity, its size (m/s)",
            title="tail's velocity (Fig. 7)",
        )
        right.set_ylim(3e-5, 5e-2)
        for ax in (left, right):
            ax.set_xlim(0, closed.t_s[-1])
        fig.suptitle(
            "implicit less exact model: three links of 1 kg, 0.12 m; α = 30°, β = 90°, "
            "ω = 3 rad/s;\nk = 1000 N/m, c = 1 N s/m, RK4 of 1 ms",
            fontsize=9,
            color=GREY,
            x=0.01,
            ha="left",
        )
        save(fig, path)
    rows = np.column_stack(
        [
            closed.t_s,
            closed.theta_error_rad,
            closed.velocity_error_m_s,
            opened.theta_error_rad,
            opened.velocity_error_m_s,
        ]
    )
    names = ("theta_error_rad", "vx_error_m_s", "vy_error_m_s")
    header = ["t_s", *(f"{gaps}_{name}" for gaps in ("closed", "opened") for name in names)]
    write_csv(beside(path), header, rows[::2].tolist())


def power_of(
    cloud: Sweep,
    front: Sequence[LeastPower],
    robust: Sequence[RobustGait],
    along: Sequence[float],
    cost: str,
    title: str,
    path: Path,
) -> None:
    """Draw the power of all gaits against speed, the least (Fig. 8), and the robust gaits'.

    along: what part of each optimum's speed counts. cost: a power's name. A robust gait stands at
    the speed that was wanted, which 95 % of the robots that may be real keep to nine tenths.
    """
    watts = getattr(cloud, f"{cost}_w")
    good = cloud.converged & (cloud.speed_m_s > 1e-3) & (watts > 0)
    speed = [b.speed_m_s * part for b, part in zip(front, along, strict=True)]
    wanted = [b.wanted_m_s for b in robust]
    told = "least power" if min(along, default=1.0) == 1.0 else "least power, speed along x"
    with figure(7.2, 5.0) as (fig, ax):
        ax.scatter(
            cloud.speed_m_s[good],
            watts[good],
            s=4,
            color="#9a9a9a",
            lw=0,
            rasterized=True,
            label=f"{int(good.sum())} gaits that travel",
        )
        ax.plot(speed, [b.power_w for b in front], "o-", color=BLUE, ms=4, label=told)
        if robust:
            extra = [max(100 * b.premium, 0.0) for b in robust]
            told = f"robust: {min(extra):.0f} to {max(extra):.0f} % more"
            ax.plot(
                wanted,
                [b.power_w for b in robust],
                "s--",
                color=RED,
                mfc="white",
                ms=5,
                lw=1.2,
                label=told,
            )
        ax.set(xlabel="speed (m/s)", ylabel="power (W)", xscale="log", yscale="log")
        if speed:  # the claim is about the front: what is far slower only shrinks it
            ax.set_xlim(left=0.5 * min(speed))
        ax.legend(loc="upper left", markerscale=1.0)
        fig.suptitle(title, fontsize=9, color=GREY)
        save(fig, path)
    rows: list[list[Any]] = [
        [
            "gait",
            float(cloud.speed_m_s[at]),
            float(watts[at]),
            round(math.degrees(cloud.alpha_rad[at[0]]), 10),
            round(math.degrees(cloud.beta_rad[at[1]]), 10),
            float(cloud.omega_rad_s[at[2]]),
        ]
        for at in map(tuple, np.argwhere(good).tolist())
    ]
    rows += [
        [
            kind,
            v,
            b.power_w,
            math.degrees(b.gait.alpha_rad),
            math.degrees(b.gait.beta_rad),
            b.gait.omega_rad_s,
        ]
        for kind, speeds, found in (("least", speed, front), ("robust", wanted, robust))
        for v, b in zip(speeds, found, strict=True)
    ]
    header = ["kind", "speed_m_s", f"{cost}_w", "alpha_deg", "beta_deg", "omega_rad_s"]
    write_csv(beside(path), header, rows)


def path_data(run: Run, path: Path) -> None:
    """Write the data of Figs. 12 and 13: every link in time, along the mean way of travel."""
    run, n = along_travel(run), run.scene.robot.links
    names = [
        f"{what}{i + 1}_{unit}"
        for what, unit in (("x", "m"), ("y", "m"), ("theta", "rad"))
        for i in range(n)
    ]
    rows = np.column_stack([run.t_s, run.x_m, run.y_m, run.theta_rad]).tolist()
    write_csv(beside(path), ["t_s", *names], rows)


def friction_data(session: Session, fit: FrictionFit, path: Path) -> None:
    """Write the points of Figs. 15 and 16 with their errors, and the fitted lines at them."""
    points, errors, whole = friction_points(session, fit), point_errors(session), fit.whole_snake
    rows = []
    for part, slope, rest in (("straight", "ct", "ft0"), ("bent", "cn", "fn0")):
        columns = (*points[part], *errors[part], whole[slope] * points[part][0] + whole[rest])
        rows += [[part, *row] for row in zip(*(c.tolist() for c in columns), strict=True)]
    write_csv(
        beside(path),
        ["part", "speed_m_s", "force_n", "speed_sigma_m_s", "force_sigma_n", "line_n"],
        rows,
    )


def speed_data(points: Sequence[SpeedPoint], path: Path) -> None:
    """Write the points of Fig. 17."""
    rows = [list(point.to_dict().values()) for point in points]
    write_csv(beside(path), list(points[0].to_dict()), rows)
