"""Figures of the 2005 paper that no other command draws: errors in time, power against speed."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ...calibration.friction_fit import friction_points, point_errors
from ...model.files import write_csv
from ...periodic.sweep import Sweep
from ..figure_data import LINES, beside, by_link, write_columns, write_parts
from ..plot import BLUE, GREY, RED, along_travel, columns, figure, heading

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
    data: dict[str, Any] = {"t_s": closed.t_s}
    with figure(9.6, 4.2, 2, path=path) as (fig, (left, right)):
        for gaps, errors, colour, style, name in (
            ("closed", closed, RED, "-", "all gaps closed at first (the paper)"),
            ("opened", opened, BLUE, "--", "gaps opened by the forces at first"),
        ):
            angle, (vx, vy) = errors.theta_error_rad, errors.velocity_error_m_s.T
            left.plot(errors.t_s, 1e3 * angle, style, color=colour, lw=1.0, label=name)
            size = np.maximum(np.hypot(vx, vy), 1e-6)
            right.semilogy(errors.t_s, size, style, color=colour, lw=0.9)
            data |= {
                f"{gaps}_theta_error_rad": angle,
                f"{gaps}_vx_error_m_s": vx,
                f"{gaps}_vy_error_m_s": vy,
            }
        left.axhspan(
            -1, 1, color="#eeeeee", zorder=0, label="1 mrad, the order that the paper tells"
        )
        left.set(
            xlabel="time (s)",
            ylabel="error of the angle (mrad)",
            title="tail's angle (Fig. 6)",
            xlim=(0, closed.t_s[-1]),
            ylim=(-1.5, 2.6),
        )
        left.legend(loc="upper right", fontsize=8)
        right.set(
            xlabel="time (s)",
            ylabel="error of the velocity, its size (m/s)",
            title="tail's velocity (Fig. 7)",
            xlim=(0, closed.t_s[-1]),
            ylim=(3e-5, 5e-2),
        )
        heading(
            fig,
            "implicit less exact model: three links of 1 kg, 0.12 m; α = 30°, β = 90°, "
            "ω = 3 rad/s;\nk = 1000 N/m, c = 1 N s/m, RK4 of 1 ms",
        )
    write_columns(path, {name: values[::2] for name, values in data.items()})


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
    with figure(7.2, 5.0, path=path) as (fig, ax):
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
            how = {"color": RED, "mfc": "white", "ms": 5, "lw": 1.2}
            ax.plot(wanted, [b.power_w for b in robust], "s--", label=told, **how)
        ax.set(xlabel="speed (m/s)", ylabel="power (W)", xscale="log", yscale="log")
        if speed:  # the claim is about the front: what is far slower only shrinks it
            ax.set_xlim(left=0.5 * min(speed))
        ax.legend(loc="upper left", markerscale=1.0)
        fig.suptitle(title, fontsize=9, color=GREY)
    alpha, beta, omega = np.meshgrid(
        np.degrees(cloud.alpha_rad).round(10),
        np.degrees(cloud.beta_rad).round(10),
        cloud.omega_rad_s,
        indexing="ij",
    )
    parts = [("gait", [v[good] for v in (cloud.speed_m_s, watts, alpha, beta, omega)])]
    for kind, speeds, optima in (("least", speed, front), ("robust", wanted, robust)):
        *angles, rate = columns([b.gait for b in optima], "alpha_rad", "beta_rad", "omega_rad_s")
        powers = columns(optima, "power_w")
        parts.append((kind, [np.array(speeds), *powers, *map(np.degrees, angles), rate]))
    names = ("speed_m_s", f"{cost}_w", "alpha_deg", "beta_deg", "omega_rad_s")
    write_parts(path, ("kind", *names), parts)


def path_data(run: Run, path: Path) -> None:
    """Write the data of Figs. 12 and 13: every link in time, along the mean way of travel."""
    turned = along_travel(run)
    tables = {"x{}_m": turned.x_m, "y{}_m": turned.y_m, "theta{}_rad": turned.theta_rad}
    write_columns(path, {"t_s": turned.t_s} | by_link(tables))


def friction_data(session: Session, fit: FrictionFit, path: Path) -> None:
    """Write the points of Figs. 15 and 16 with their errors, and the fitted lines at them."""
    points, errors, whole = friction_points(session, fit), point_errors(session), fit.whole_snake
    names = ("part", "speed_m_s", "force_n", "speed_sigma_m_s", "force_sigma_n", "line_n")
    parts = []
    for part in ("straight", "bent"):
        speed, force = points[part]
        slope, rest = (whole[name] for name in LINES[part])
        parts.append((part, [speed, force, *errors[part], slope * speed + rest]))
    write_parts(path, names, parts)


def speed_data(points: Sequence[SpeedPoint], path: Path) -> None:
    """Write the points of Fig. 17."""
    rows = [list(point.to_dict().values()) for point in points]
    write_csv(beside(path), list(points[0].to_dict()), rows)
