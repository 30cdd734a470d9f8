"""Measured speeds over predicted ones, and what is left between them."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..prediction.comparison import ComparedGait, Comparison
from ..prediction.curve import speed_curves
from .plot import BLUE, GREEN, GREY, ORANGE, PURPLE, columns, draw_curve, hatch_beyond

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLORS = BLUE, GREEN, PURPLE, ORANGE


def panels(compared: Comparison) -> dict[str, Any]:
    """Return the panels of the drawing: that of the residuals where a gait was run."""
    ran = any(gait.measured_m_s is not None for gait in compared.gaits)
    return {"rows": 2, "sharex": True, "height_ratios": [3, 1]} if ran else {}


def draw_comparison(fig: Figure, axes: Any, compared: Comparison) -> None:
    """Draw speed over frequency, each gait on the curve of its shape, and residuals below."""
    top, *residual_axes = np.atleast_1d(axes)
    last_hz = 1.4 * max(gait.frequency_hz for gait in compared.gaits)
    kind = compared.servo and compared.servo.name
    moved_by = f"typical {kind} servos" if kind else "ideal joints"
    curves = speed_curves(compared)
    for curve, color in zip(curves, itertools.cycle(COLORS)):
        angles = np.degrees(curve.shape)
        label = f"{angles[0]:.3g}°/{angles[1]:.3g}°, {moved_by}; 95 % band"
        draw_curve(top, curve, color, label)
        gaits = [gait for gait in compared.gaits if (gait.alpha_rad, gait.beta_rad) == curve.shape]
        if residual_axes:
            _measured(top, residual_axes[0], gaits, color)
    if len(curves) == 1:
        hatch_beyond(top, curves[0].highest_hz, last_hz, f"a typical {kind} servo")
    words = "dots: measured, ± 95 %" if residual_axes else "no gait run measured"
    top.set(title=f"{compared.session}; {words}", ylabel="speed (m/s)")
    top.set(
        xlim=(0, last_hz), ylim=(0, (1.15 + 0.08 * len(curves)) * top.get_ylim()[1])
    )  # room for the legend
    if curves:
        top.legend(loc="upper left", fontsize=8)
    if residual_axes:
        residual_axes[0].axhline(0, color=GREY)
        residual_axes[0].set(ylabel="measured less\npredicted (%)")
    (*residual_axes, top)[0].set_xlabel("gait frequency (Hz)")
    fig.align_ylabels()


def _measured(top: Axes, bottom: Axes, gaits: Sequence[ComparedGait], color: str) -> None:
    """Draw the gaits that were run, and how far they are from the prediction, with its band."""
    ran = [gait for gait in gaits if gait.measured_m_s is not None]
    f, measured, sigma, typical = columns(
        ran, "frequency_hz", "measured_m_s", "sigma_m_s", "typical_m_s"
    )
    dots = {"fmt": "o", "color": color, "mec": "black", "capsize": 3, "ms": 5}
    top.errorbar(f, measured, 1.96 * sigma, **dots)
    percent = 100 * (measured / typical - 1)
    bottom.errorbar(f, percent, 196 * sigma / typical, **dots)
    f, typical, low, high = columns(
        [gait for gait in ran if gait.low_all_m_s is not None],
        *("frequency_hz", "typical_m_s", "low_all_m_s", "high_all_m_s"),
    )
    ends = 100 * (low / typical - 1), 100 * (high / typical - 1)
    bottom.vlines(f, *ends, color=color, lw=7, alpha=0.25)
