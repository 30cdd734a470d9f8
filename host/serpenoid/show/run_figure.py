"""The picture of one run in time: where the snake went, how fast, and where the energy went."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..model.gait import gait_name
from ..simulation.run import ENERGY_COLUMNS, Run
from .plot import (
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    RED,
    along_travel,
    draw_links,
    draw_path,
    figure,
    heading,
    robot_words,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ..simulation.scene import Scene


def run_figure(run: Run, path: Path | None) -> Figure:
    """Draw the path seen from above, the speed, and the energy ledger where it was recorded.

    The path is turned so that the way from start to end lies along x.
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
    """Say what was run: robot, gait, drive, start, slope, faults, model, method."""
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
    """Draw the centre of mass's speed, and how far it came in the period before, by its length."""
    t, period = run.t_s, run.scene.gait.period_s
    ax.plot(t, np.hypot(*run.centre_velocity_m_s.T), color=GREY, lw=1.0, label="at the moment")
    if t[-1] > period:
        mean = run.mean_speed_m_s(period)
        ax.plot(t[-mean.size :], mean, color=BLUE, label="over the last period")
    ax.set(title="speed of the centre of mass", ylabel="speed (m/s)")
    ax.set_ylim(bottom=0)
    ax.legend(loc="best")


def _energy(ax: Axes, run: Run) -> None:
    """Draw d(stores) = joints' work - heat, each since the start."""
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
