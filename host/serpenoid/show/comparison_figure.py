"""Measured speeds over predicted ones, and what is left between them."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..base.vectors import columns
from ..prediction.comparison import ComparedGait, Comparison, speed_curves
from ..servos.speed_limit import highest_hz
from .plot import COLOURS, GREY, hatch_beyond


def panels(compared: Comparison) -> dict[str, Any]:
    """Return the panels of the drawing: that of the residuals where a gait was run."""
    ran = any(gait.runs for gait in compared.gaits)
    return {"rows": 2, "sharex": True, "height_ratios": [3, 1]} if ran else {}


def draw_comparison(fig: Figure, axes: Any, compared: Comparison) -> None:
    """Draw speed over frequency, each gait on the curve of its shape, and residuals below."""
    top, *residual_axes = np.atleast_1d(axes)
    last_hz = 1.4 * max(row.frequency_hz for row in compared.gaits)
    kind = compared.servo and compared.servo.name
    moved_by = f"typical {kind} servos" if kind else "ideal joints"
    curves = speed_curves(compared)
    for (shape, bands), color in zip(curves.items(), itertools.cycle(COLOURS)):
        angles = np.degrees(shape)
        label = f"{angles[0]:.3g}°/{angles[1]:.3g}°, {moved_by}; 95 % band"
        f_hz, typical, low, high = columns(
            bands, "frequency_hz", "speed_m_s", "low_m_s", "high_m_s"
        )
        top.fill_between(f_hz, low, high, color=color, alpha=0.18, lw=0)
        top.plot(f_hz, typical, color=color, label=label)
        gaits = [row for row in compared.gaits if (row.gait.alpha_rad, row.gait.beta_rad) == shape]
        if residual_axes:
            _measured(top, residual_axes[0], gaits, color)
    if len(curves) == 1 and compared.servo:
        highest = highest_hz(compared.gaits[0].gait, compared.servo)
        hatch_beyond(top, highest, last_hz, f"a typical {kind} servo")
    words = "dots: measured, ± 95 %" if residual_axes else "no gait run measured"
    top.set(title=f"{compared.session}; {words}", ylabel="speed (m/s)")
    top.set(
        xlim=(0, last_hz), ylim=(0, (1.15 + 0.08 * len(curves)) * top.get_ylim()[1])
    )  # room for the legend
    if curves:
        top.legend(loc="upper left")
    if residual_axes:
        residual_axes[0].axhline(0, color=GREY)
        residual_axes[0].set(ylabel="measured less\npredicted (%)")
    (*residual_axes, top)[0].set_xlabel("gait frequency (Hz)")
    fig.align_ylabels()


def _measured(top: Axes, bottom: Axes, gaits: Sequence[ComparedGait], color: str) -> None:
    """Draw the gaits that were run, and how far they are from the prediction, with its band."""
    ran = [gait for gait in gaits if gait.runs]
    f, measured, sigma, typical, low, high = columns(
        ran, "frequency_hz", "measured_m_s", "sigma_m_s", "speed_m_s", "low_m_s", "high_m_s"
    )
    dots = {"fmt": "o", "color": color, "mec": "black", "capsize": 3, "ms": 5}
    top.errorbar(f, measured, 1.96 * sigma, **dots)
    bottom.errorbar(f, 100 * (measured / typical - 1), 196 * sigma / typical, **dots)
    ends = 100 * (low / typical - 1), 100 * (high / typical - 1)
    bottom.vlines(f, *ends, color=color, lw=7, alpha=0.25)
