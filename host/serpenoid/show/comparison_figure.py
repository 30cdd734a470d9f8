"""Measured speeds over predicted ones, and what is left between them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..prediction.comparison import ComparedGait, Comparison
from .plot import BLUE, GREY, HUGS, ORANGE, RED, columns, figure, hatch_beyond

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SIZE = 7.2, 6.0  # inches
PANELS: dict[str, Any] = {"rows": 2, "sharex": True, "height_ratios": [3, 1]}


def comparison_figure(compared: Comparison, path: Path) -> None:
    """Draw a comparison into a file."""
    with figure(*SIZE, path=path, **PANELS) as (fig, axes):
        draw_comparison(fig, axes, compared)


def draw_comparison(fig: Figure, axes: Any, compared: Comparison) -> None:
    """Draw speed over frequency and residuals below it."""
    top, bottom = axes
    _predicted(top, compared)
    ran = tuple(p for p in compared.gaits if p.measured_m_s is not None)
    if ran:
        f, measured, sigma = columns(ran, "frequency_hz", "measured_m_s", "sigma_m_s")
        top.errorbar(
            f, measured, 1.96 * sigma, fmt="o", color=RED, capsize=3, ms=5, label="measured, 95 %"
        )
    _residuals(bottom, ran)
    first = compared.curve[0]
    top.set(
        title=f"{compared.session}: α = {np.degrees(first.alpha_rad):.3g}°, "
        f"β = {np.degrees(first.beta_rad):.3g}°",
        ylabel="speed (m/s)",
        ylim=(0, 1.2 * top.get_ylim()[1]),  # room for the legend
    )
    top.legend(loc="upper left")
    bottom.set_xlim(0, 1.02 * compared.curve[-1].frequency_hz)
    fig.align_ylabels()
    fig.supxlabel(HUGS, fontsize=8, color=GREY)


def _predicted(ax: Axes, compared: Comparison) -> None:
    f, exact, low, high, implicit = columns(
        compared.curve, "frequency_hz", "exact_m_s", "low_m_s", "high_m_s", "implicit_m_s"
    )
    ax.fill_between(
        f,
        low,
        high,
        color=BLUE,
        alpha=0.18,
        lw=0,
        label="95 % of the frictions that the fit allows",
    )
    ax.plot(f, exact, color=BLUE, label="exact model")
    ax.plot(f, implicit, ".", color=ORANGE, ms=6, label="implicit model, k = 1000 N/m")
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
    hatch_beyond(
        ax, compared.highest_hz, 1.02 * compared.curve[-1].frequency_hz, str(compared.servo)
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
