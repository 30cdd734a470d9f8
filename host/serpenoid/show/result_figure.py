"""The figure of each kind of result, for `.plot()`."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from ..base.errors import NotConverged
from ..base.vectors import Array, columns
from ..friction.result import FrictionFit
from ..model.gait import gait_name
from ..periodic.steady import Steady, steady_gait
from ..periodic.sweep import Sweep
from ..prediction.comparison import Comparison
from ..session.session import Session
from ..simulation.run import Run
from .comparison_figure import draw_comparison, panels
from .gaits.gait_figures import power_of
from .plot import BLUE, COLOURS, draw_friction, figure, hatch_beyond, heading
from .run_figure import run_figure
from .session.floor_figure import draw_pushes


def figure_of(result: Any, path: Path | None, **details: Any) -> Figure:
    """Return the figure of a result, written into a file if one is given."""
    return FIGURES[type(result)](result, path, **details)


def fit_figure(
    fit: FrictionFit, path: Path | None, session: Session | None = None, note: str = ""
) -> Figure:
    """Draw a fit's lines, and the readings of a session; of one on a floor its pushes."""
    with figure(9.0, 4.2, 2, path=path) as (fig, axes):
        if session is not None and session.on_floor:
            draw_pushes(fig, axes, session, fit)
        else:
            draw_friction(fig, axes, fit, session, note)
        return fig


def comparison_figure(compared: Comparison, path: Path | None) -> Figure:
    """Draw speeds over frequency: measured ones beside the predicted band."""
    with figure(7.2, 6.0, path=path, **panels(compared)) as (fig, axes):
        draw_comparison(fig, axes, compared)
        return fig


def steady_figure(state: Steady, path: Path | None) -> Figure:
    """Draw speed and power of a gait over its frequency, and a dot at its own."""
    gait, states = state.gait, list[Steady]()
    for rate in (np.linspace(0.2, 2.0, 19) * gait.omega_rad_s).tolist():
        faster = replace(gait, omega_rad_s=rate)
        with suppress(NotConverged):
            states.append(steady_gait(state.robot, state.ground, faster, rtol=1e-3))
    (omega,) = columns([s.gait for s in states], "omega_rad_s")
    speed, power = columns(states, "speed_m_s", "power_w")
    with figure(8.4, 3.8, 2, path=path) as (fig, axes):
        _over_frequency(axes, omega / math.tau, speed, power)
        for ax, value in zip(axes, (state.speed_m_s, state.power_w), strict=True):
            ax.plot(gait.omega_rad_s / math.tau, value, "o", color=BLUE, mec="black")
            ax.set_ylim(0, None)
        heading(fig, f"{gait_name(gait)}; ideal joints")
        return fig


def sweep_figure(grid: Sweep, path: Path | None) -> Figure:
    """Draw speed and power of a few shapes over frequency; power over speed of many."""
    hertz, title = grid.omega_rad_s / math.tau, grid.in_words().replace(". ", ".\n")
    names = "speed_m_s", "power_w", "servo_speed_m_s", "servo_low_m_s", "servo_high_m_s"
    tables = [getattr(grid, name) for name in names if getattr(grid, name) is not None]
    tables = [values.reshape(-1, hertz.size) for values in tables]
    shapes = list(product(np.degrees(grid.alpha_rad), np.degrees(grid.beta_rad)))
    most_curves = 4  # Shapes that can be told apart in one figure.
    if len(tables[0]) > most_curves:
        return power_of(grid, [], title, path)
    with figure(8.4, 4.2, 2, path=path) as (fig, axes):
        for k, (color, speed, power, *servo) in enumerate(zip(COLOURS, *tables, strict=False)):
            alpha, beta = shapes[k % len(shapes)]
            label = f"{alpha:.3g}°/{beta:.3g}°, ideal joints"
            _over_frequency(axes, hertz, speed, power, label, color)
            if servo:
                typical, low, high = servo
                followed = np.where(np.isnan(low), np.nan, typical)
                axes[0].plot(hertz, followed, "--", color=color, label="with the servo; 95 % band")
                axes[0].fill_between(hertz, low, high, color=color, alpha=0.18, lw=0)
                if len(tables[0]) == 1:
                    highest_hz = max(hertz[~np.isnan(low)], default=0.0)
                    hatch_beyond(axes[0], highest_hz, hertz[-1], "the servo")
        axes[0].set_ylim(0, 1.3 * axes[0].get_ylim()[1])  # room for the legend
        axes[0].legend(loc="upper left")
        heading(fig, title)
        return fig


def _over_frequency(
    axes: Any, hertz: Array, speed: Array, power: Array, label: str = "", color: str = BLUE
) -> None:
    """Draw a speed and a power over frequency."""
    for ax, curve, name in zip(axes, (speed, power), ("speed (m/s)", "net power (W)"), strict=True):
        ax.plot(hertz, curve, ".-", ms=4, color=color, label=label)
        ax.set(xlabel="gait frequency (Hz)", ylabel=name, xlim=(0, None))


FIGURES: dict[type, Callable[..., Figure]] = {
    Run: run_figure,
    Sweep: sweep_figure,
    Steady: steady_figure,
    FrictionFit: fit_figure,
    Comparison: comparison_figure,
}
