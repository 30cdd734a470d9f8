"""Tables of what follows from a fit: the comparison, and the next reading."""

from __future__ import annotations

import math

from ..calibration.advising.next_reading import Advice
from ..calibration.advising.two_fits import TwoFits
from ..calibration.comparison import ComparedGait, Comparison
from .report import answer, console, table

MEASURED = ["gait", "measured", "95 % predicted", "off ideal joints by"]
WORTH = 0.02  # of the band: a reading that saves less is not to be taken


def show_comparison(found: Comparison) -> None:
    """Print predicted and measured speeds, and the verdict."""
    answer(found.verdict_text)
    title = f"{found.session}: predicted speed, m/s"
    table(title, predicted_columns(found), list(map(predicted_row, found.gaits)))
    ran = [measured_row(p) for p in found.gaits if p.measured_m_s is not None]
    if ran:
        table("measured speed, m/s", MEASURED, ran)


def predicted_columns(found: Comparison, unit: str = "") -> list[str]:
    """Return the heads of a table of predicted speeds."""
    joints = "friction, joints" + ("" if found.servo is None else f", servos: {found.servo}")
    return ["gait", f"exact{unit}", "implicit", "95 % friction", f"95 % {joints}"]


def _gait(p: ComparedGait) -> str:
    alpha, beta = math.degrees(p.alpha_rad), math.degrees(p.beta_rad)
    return f"{alpha:.3g}°/{beta:.3g}°, {p.frequency_hz:.3g} Hz"


def predicted_row(p: ComparedGait) -> list[str]:
    """Return the predicted speeds of a gait."""
    return [
        _gait(p),
        f"{p.exact_m_s:.4f}",
        "–" if p.implicit_m_s is None else f"{p.implicit_m_s:.4f}",
        f"{p.low_m_s:.4f} to {p.high_m_s:.4f}",
        f"{p.low_all_m_s:.4f} to {p.high_all_m_s:.4f}",
    ]


def measured_row(p: ComparedGait) -> list[str]:
    """Return the measured speed of a gait beside its band."""
    off = f"{100 * ((p.measured_m_s or 0.0) / p.exact_m_s - 1):+.1f} %" if p.exact_m_s else ""
    measured = f"{p.measured_m_s:.4f} ± {p.sigma_m_s:.4f}"
    return [_gait(p), measured, f"{p.low_all_m_s:.4f} to {p.high_all_m_s:.4f}", off]


def show_two_fits(found: TwoFits) -> None:
    """Print the frictions of two sessions, and whether they agree."""
    table("friction in two sessions, whole snake", *two_fits_table(found))
    console.print(f"p = {found.p_value:.2g}. {found.verdict}", highlight=False)


def two_fits_table(found: TwoFits) -> tuple[list[str], list[list[str]]]:
    """Return heads and rows of a table of two sessions' frictions."""
    rows = [
        [r.name, r.unit, f"{r.first:.4g}", f"{r.second:.4g}", f"{r.sigmas:+.1f}"]
        for r in found.rows
    ]
    return ["whole snake", "unit", found.first, found.second, "differs by (sigmas)"], rows


def advice_table(found: Advice, most: int) -> tuple[list[str], list[list[str]]]:
    """Return heads and rows of a table of readings; minutes where they are known."""
    timed = found.best.minutes is not None
    rows = [
        [r.in_words(), *([f"{r.minutes or 0:.1f}"] if timed else []), f"{r.band_after_times:.1%}"]
        for r in found.readings[:most]
    ]
    return ["reading", *(["minutes"] if timed else []), "afterwards"], rows


def show_advice(found: Advice, most: int = 5) -> None:
    """Print the readings that are worth most, and the best one in words."""
    if found.note:
        answer(found.note)
    if found.measure_servo and found.band - found.band_after_best < WORTH * found.band:
        answer("No further push, slide or station is worth its time now.")
    else:
        first = "Of the readings take" if found.measure_servo else "Take next:"
        after = f"then the speed is known to {found.band_after_best:.1%}"
        answer(f"{first} {found.best.in_words()}; {after}.")
    servos = "" if found.servo is None else f", servos: {found.servo}"
    table(
        f"speed is known to {found.band:.1%} (95 %, friction and joints{servos})",
        *advice_table(found, most),
    )
