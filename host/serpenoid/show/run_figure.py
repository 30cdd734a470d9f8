"""The picture of one run in time: where the snake went, how fast, and where the energy went."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..simulation.run import ENERGY_COLUMNS, Run
from .plot import BLUE, GREEN, GREY, ORANGE, RED, draw_links, figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_POSES = 4


def draw_run(run: Run, path: Path) -> None:
    """Draw the path seen from above, the speed, and the energy ledger where it was recorded."""
    ledger = run.energy_j.size > 0
    with figure(9.0, 9.0 if ledger else 6.6) as (fig, _unused):
        fig.clear()
        axes = fig.subplots(3 if ledger else 2, 1, height_ratios=[1.6, 1, 1.2][: 2 + ledger])
        _path(axes[0], run)
        _speed(axes[1], run)
        if ledger:
            _energy(axes[2], run)
        axes[-1].set_xlabel("time (s)")
        fig.savefig(path)


def _path(ax: Axes, run: Run) -> None:
    for name, x, y, colour, width in (
        ("tail", run.x_m[:, 0], run.y_m[:, 0], ORANGE, 1.0),
        ("head", run.x_m[:, -1], run.y_m[:, -1], BLUE, 1.0),
        ("centre of mass", *run.centre_m.T, "black", 2.0),
    ):
        ax.plot(x, y, color=colour, lw=width, label=name)
    for index in np.unique(np.linspace(0, run.t_s.size - 1, _POSES).astype(int)):
        draw_links(ax, run, int(index), 0.0, "#a0a0a0")
    scene = run.scene
    ax.set_title(
        f"path over the ground, {run.t_s[-1]:g} s; {scene.formulation} model, {scene.method}; "
        "grey: the snake, a dot on its head"
    )
    ax.set(xlabel="x (m)", ylabel="y (m)")
    ax.set_aspect("equal", adjustable="datalim")
    ax.legend(loc="best")


def _speed(ax: Axes, run: Run) -> None:
    """Draw the centre of mass's speed, and how far it came in the period before, by its length."""
    t, period = run.t_s, run.scene.gait.period_s
    ax.plot(t, np.hypot(*run.centre_velocity_m_s.T), color=GREY, lw=1.0,
            label="at the moment")  # fmt: skip
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
