"""What the command line says of optima: their error, limits and margins."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from ...servos.catalogue import HOBBY
from ...servos.speed_limit import too_fast_text
from ..report import notices, table

if TYPE_CHECKING:
    from ...gaits.finder import LeastPower
    from ...gaits.margins import Margins
    from ...periodic.servo_steady import ServoSteady


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
