"""Tables of what follows from a fit: the comparison, and the next reading."""

from __future__ import annotations

import math

from ..calibration.advice import Advice
from ..calibration.comparison import ComparedGait, Comparison
from .report import console, table


def show_comparison(found: Comparison) -> None:
    """Print predicted and measured speeds, and the verdict."""
    columns = ["gait", "exact", "95 % friction", "with joints", "implicit", "measured", "off by"]
    title = f"{found.session}: predicted and measured speed, m/s"
    table(title, columns, list(map(_row, found.gaits)))
    console.print(found.verdict_text, highlight=False)


def _row(p: ComparedGait) -> list[str]:
    alpha, beta = math.degrees(p.alpha_rad), math.degrees(p.beta_rad)
    measured = off = ""
    if p.measured_m_s is not None and p.sigma_m_s is not None:
        measured = f"{p.measured_m_s:.4f} ± {p.sigma_m_s:.4f}"
        off = f"{100 * (p.measured_m_s / p.exact_m_s - 1):+.1f} %" if p.exact_m_s else ""
    return [
        f"{alpha:.3g}°/{beta:.3g}°, {p.frequency_hz:.3g} Hz",
        f"{p.exact_m_s:.4f}",
        f"{p.low_m_s:.4f}–{p.high_m_s:.4f}",
        f"{p.low_all_m_s:.4f}–{p.high_all_m_s:.4f}",
        "–" if math.isnan(p.implicit_m_s) else f"{p.implicit_m_s:.4f}",
        measured,
        off,
    ]


def show_advice(found: Advice, most: int = 5) -> None:
    """Print the readings that are worth most, and the best one in words."""
    rows = [
        [r.in_words(), f"{r.band_after_times:.1%}" if r.times > 1 else f"{r.band:.1%}"]
        for r in found.readings[:most]
    ]
    table(
        f"speed is known to {found.band:.1%} (95 %, friction and joints)",
        ["reading", "afterwards"],
        rows,
    )
    if found.note:
        console.print(found.note, highlight=False)
    after = f"then the speed is known to {found.band_after_best:.1%}"
    console.print(f"Take next: {found.best.in_words()}; {after}.", highlight=False)
