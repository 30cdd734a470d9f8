"""Measured speeds over predicted ones, and what is left between them."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..prediction.comparison import ComparedGait, Comparison
from ..prediction.curve import SpeedCurve, speed_curves
from .plot import BLUE, GREEN, GREY, HUGS, ORANGE, PURPLE, RED, columns, figure, hatch_beyond

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ..calibration.friction_result import FrictionFit

SIZE = 7.2, 6.0  # inches
COLORS = BLUE, GREEN, PURPLE
PANELS: dict[str, Any] = {"rows": 2, "sharex": True, "height_ratios": [3, 1]}


def comparison_figure(compared: Comparison, fit: FrictionFit, path: Path) -> None:
    """Draw a comparison, with the curves that its fit predicts, into a file."""
    with figure(*SIZE, path=path, **PANELS) as (fig, axes):
        draw_comparison(fig, axes, compared, speed_curves(fit, compared))


def draw_comparison(
    fig: Figure, axes: Any, compared: Comparison, curves: Sequence[SpeedCurve]
) -> None:
    """Draw speed over frequency and residuals below it."""
    top, bottom = axes
    most_hz = 1.02 * float(curves[0].frequency_hz[-1])
    for curve, color in zip(curves, itertools.cycle(COLORS)):
        _predicted(top, compared, curve, color)
    _bands(top, compared)
    if len(curves) == 1:
        hatch_beyond(top, compared.highest_hz, most_hz, str(compared.servo))
    ran = tuple(p for p in compared.gaits if p.measured_m_s is not None)
    if ran:
        f, measured, sigma, implicit = columns(
            ran, "frequency_hz", "measured_m_s", "sigma_m_s", "implicit_m_s"
        )
        top.plot(f, implicit, ".", color=ORANGE, ms=6, label="implicit model, k = 1000 N/m")
        top.errorbar(
            f, measured, 1.96 * sigma, fmt="o", color=RED, capsize=3, ms=5, label="measured, 95 %"
        )
    _residuals(bottom, ran)
    top.set(
        title=compared.session,
        ylabel="speed (m/s)",
        ylim=(0, 1.3 * top.get_ylim()[1]),  # room for the legend
    )
    top.legend(loc="upper left", fontsize=8)
    bottom.set_xlim(0, most_hz)
    fig.align_ylabels()
    fig.supxlabel(HUGS, fontsize=8, color=GREY)


def _predicted(ax: Axes, compared: Comparison, curve: SpeedCurve, color: str) -> None:
    """Draw one gait shape's curve; dots of its colour are the gaits of this shape."""
    f = curve.frequency_hz
    ax.fill_between(f, curve.low_m_s, curve.high_m_s, color=color, alpha=0.18, lw=0)
    shape = f"{np.degrees(curve.alpha_rad):.3g}°/{np.degrees(curve.beta_rad):.3g}°"
    ax.plot(f, curve.exact_m_s, color=color, label=f"{shape}, exact model, 95 % by friction")
    own = [g for g in compared.gaits if (g.alpha_rad, g.beta_rad) == curve.shape]
    f, exact = columns(own, "frequency_hz", "exact_m_s")
    ax.plot(f, exact, "d", color=color, ms=4)


def _bands(ax: Axes, compared: Comparison) -> None:
    f, low, high = columns(compared.gaits, "frequency_hz", "low_all_m_s", "high_all_m_s")
    servos = "" if compared.servo is None else f", servos: {compared.servo}"
    ax.vlines(
        f,
        low,
        high,
        color=GREY,
        lw=6,
        alpha=0.35,
        label=f"with the joints' amplitude, {compared.amplitude_sigma:.0%}{servos}",
    )


def _residuals(ax: Axes, ran: tuple[ComparedGait, ...]) -> None:
    ax.axhline(0, color=BLUE)
    ax.set(xlabel="gait frequency (Hz)", ylabel="measured less\nexact (%)")
    if not ran:
        ax.set(title="no gait run measured yet", yticks=[])
        return
    f, residual, sigma, exact = columns(
        ran, "frequency_hz", "residual_m_s", "sigma_m_s", "exact_m_s"
    )
    low, high = columns(ran, "low_all_m_s", "high_all_m_s")
    ax.vlines(f, 100 * (low / exact - 1), 100 * (high / exact - 1), color=GREY, lw=6, alpha=0.35)
    ax.errorbar(f, 100 * residual / exact, 196 * sigma / exact, fmt="o", color=RED, capsize=3, ms=5)
