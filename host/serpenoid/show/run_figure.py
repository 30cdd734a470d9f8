"""Draw one run: its path, its speed, and its energies over time."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..model.gait import gait_name
from ..model.ground import Ground
from ..model.robot import Robot
from ..simulation.run import ENERGY_COLUMNS, Run
from ..simulation.scene import Scene
from .plot import BLUE, COLOURS, GREEN, GREY, ORANGE, RED, figure, heading


def run_figure(run: Run, path: Path | None) -> Figure:
    """Return the figure of a run: path from above, speed, and energies if they were recorded.

    The path is rotated so that its end lies on the x axis. path: file to write, None for none.
    """
    ledger = run.energy_j.size > 0
    heights = [3.2, 2.0, 2.4][: 2 + ledger]
    high = sum(heights) + 0.8 * len(heights) + 0.9
    panels = {"rows": len(heights), "height_ratios": heights}
    with figure(9.0, high, path=path, **panels) as (fig, axes):
        _path(axes[0], along_travel(run))
        _speed(axes[1], run)
        if ledger:
            _energy(axes[2], run)
        axes[-1].set_xlabel("time (s)")
        heading(fig, scene_words(run.scene))
        return fig


def scene_words(scene: Scene) -> str:
    """Return a scene in words: robot, gait, slope, faults, drive, start, model, method."""
    start = scene.start if isinstance(scene.start, str) else "a given state"
    parts = [robot_words(scene.robot, scene.ground), gait_name(scene.gait)]
    if scene.incline_rad:
        parts.append(f"slope of {math.degrees(scene.incline_rad):.3g}°")
    parts += [f"joint {j} limp" for j in scene.limp]
    parts += [f"joint {j} locked" for j in scene.locked]
    how = [
        f"drive: {scene.drive}",
        f"start: {start.replace('_', ' ')}",
        f"{scene.formulation} model, {scene.method}",
    ]
    return "; ".join(parts) + "\n" + "; ".join(how)


def _path(ax: Axes, turned: Run) -> None:
    draw_path(ax, turned)
    for index in np.unique(np.linspace(0, turned.t_s.size - 1, 4).astype(int)):
        draw_links(ax, turned, int(index), 0.0, "#a0a0a0")
    title = f"path over the ground, {turned.t_s[-1]:g} s; grey: the snake, a dot on its head"
    ax.set_title(title, pad=22)
    ax.set(xlabel="along the way from start to end (m)", ylabel="across it (m)")
    ax.set_aspect("equal", adjustable="datalim")


def _speed(ax: Axes, run: Run) -> None:
    """Draw the speed of the centre of mass, and its mean over the last period."""
    t, period = run.t_s, run.scene.gait.period_s
    ax.plot(t, np.hypot(*run.centre_velocity_m_s.T), color=GREY, lw=1.0, label="at the moment")
    if t[-1] > period:
        mean = run.mean_speed_m_s(period)
        ax.plot(t[-mean.size :], mean, color=BLUE, label="over the last period")
    ax.set(title="speed of the centre of mass", ylabel="speed (m/s)")
    ax.set_ylim(bottom=0)
    ax.legend(loc="best")


def _energy(ax: Axes, run: Run) -> None:
    """Draw the energies since the start: work of the joints = heat + change of stored energy."""
    energy = dict(zip(ENERGY_COLUMNS, run.energy_j.T, strict=True))
    stores = energy["kinetic_j"] + energy["springs_j"] + energy["height_j"]
    for name, values, colour in (
        ("work of the joints", energy["joint_work_j"], BLUE),
        ("friction's heat", energy["friction_heat_j"], RED),
        ("dampers' heat", energy["damper_heat_j"], ORANGE),
        ("kept: motion, springs, height", stores - stores[0], GREEN),
    ):
        if np.any(values):
            ax.plot(run.t_s, values, color=colour, label=name)
    ax.set(title="energy since the start: work = heat + kept", ylabel="energy (J)")
    ax.legend(loc="best")


def draw_links(ax: Axes, run: Run, index: int, lift_m: float, colour: Any) -> None:
    """Draw the links of a recorded state, lifted by lift_m in y, with a dot on the head."""
    x, y, angle = run.x_m[index], run.y_m[index] + lift_m, run.theta_rad[index]
    ends = np.outer([-0.5, 0.5], run.scene.robot.link_length_m * np.exp(1j * angle)) + x + 1j * y
    ax.plot(ends.real, ends.imag, color=colour, lw=3.2, solid_capstyle="round")
    ax.plot(ends[-1, -1].real, ends[-1, -1].imag, "o", color=colour, ms=6)


def draw_path(ax: Axes, run: Run) -> None:
    """Draw the paths of tail, head and centre of mass, with a legend above."""
    ax.plot(run.x_m[:, 0], run.y_m[:, 0], color=ORANGE, lw=1.0, label="tail")
    ax.plot(run.x_m[:, -1], run.y_m[:, -1], color=BLUE, lw=1.0, label="head")
    ax.plot(*run.centre_m.T, color="black", lw=2.0, label="centre of mass")
    ax.plot(0, 0, "o", mfc="white", mec="black", ms=7, zorder=5, label="start")
    ax.legend(loc="lower left", bbox_to_anchor=(-0.01, 0.985), ncols=4)


def along_travel(run: Run) -> Run:
    """Return a run rotated and moved such that it starts at the origin and travels along x."""
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
    """Return a robot and the friction of the whole snake in words, for a title."""

    def ends(along: float | tuple[float, float]) -> str:
        return "/".join(f"{value:.3g}" for value in np.atleast_1d(along))

    ground_of_body = ground.scaled(*4 * [robot.links])
    friction = f"ct {ends(ground_of_body.ct)}, cn {ground_of_body.cn:.3g} N s/m"
    if ground.dry:
        friction += f", ft0 {ends(ground_of_body.ft0)}, fn0 {ground_of_body.fn0:.3g} N"
    return f"{robot.links} links of {robot.link_length_m:g} m, {robot.mass_kg:.4g} kg; {friction}"
