"""What the command line says of optima: their error, limits, margins and doubts."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from ...servos.catalogue import HOBBY
from ...servos.speed_limit import too_fast_text
from ..report import console, notices, table

if TYPE_CHECKING:
    from ...gaits.finder import LeastPower
    from ...gaits.margins import Margins
    from ...periodic.servo_steady import ServoSteady
    from ...prediction.speed_doubts import SpeedDoubts


def doubts(doubted: SpeedDoubts) -> None:
    """Print what makes a predicted speed's interval wide."""
    columns = ["uncertain", "by derivatives", "by draws"]
    table("what that leaves of the predicted speed, 1 sigma", columns, doubted.rows())
    console.print(doubted.in_words())


def warn(best: LeastPower, moved: ServoSteady | None) -> None:
    """Warn of a gait that is too fast; moved: servos that say so."""
    too_fast = too_fast_text(best.gait, moved.servo if moved else HOBBY)
    if too_fast:
        told = "" if moved else f"{too_fast} "
        notices.print(
            f"serpenoid: warning: {told}--set servo_speed_deg_s=... keeps the search to what "
            "servos can do"
        )


def warn_of_cliff(margins: Margins) -> None:
    """Warn beside a sharp drop of the speed."""
    if margins.warning:
        notices.print(f"serpenoid: warning: {margins.warning}")


def margins_in_sigmas(sigmas: dict[str, float]) -> None:
    """Print `Margins.in_sigmas`, of a fit."""
    known = {name: share for name, share in sigmas.items() if math.isfinite(share)}
    if known:
        in_words = ", ".join(
            f"{name.partition('_')[0]} {share:.2g}" for name, share in known.items()
        )
        console.print(f"margins in standard deviations: {in_words}")


def front(speeds_m_s: Sequence[float], optima: Sequence[LeastPower | None]) -> None:
    """Print the least-power gaits of many speeds."""
    cells = []
    for speed, best in zip(speeds_m_s, optima, strict=True):
        cells.append([f"{speed:.4g}"])
        if best is None:
            cells[-1] += ["out of reach"]
            continue
        angles = best.gait.alpha_rad, best.gait.beta_rad
        cells[-1] += [f"{best.power_w:.5g}", f"{best.gait.omega_rad_s:.4g}"]
        cells[-1] += [f"{math.degrees(angle):.4g}" for angle in angles]
        cells[-1] += [", ".join(best.active) or "none"]
    heads = ["speed (m/s)", "W", "omega (rad/s)", "alpha (deg)", "beta (deg)", "limits reached"]
    table("gaits of least power", heads, cells)
    for speed, best in zip(speeds_m_s, optima, strict=True):
        too_fast = best and too_fast_text(best.gait, HOBBY, f"The gait for {speed:.4g} m/s")
        if too_fast:
            notices.print(f"serpenoid: warning: {too_fast}")
