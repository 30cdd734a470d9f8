"""What the command line says of optima: their error, limits, margins and doubts."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from ..report import console, notices, table

if TYPE_CHECKING:
    from ...calibration.advising.speed_doubts import SpeedDoubts
    from ...gaits.finder import LeastPower
    from ...gaits.margins import Margins
    from ...gaits.robust import RobustGait
    from ...periodic.sensitivities import Sensitivities


_FASTEST_SERVO_RAD_S = 30.0  # no load, the fastest that hobbyists can buy; common ones make 5 to 10


def sensitivities(found: Sensitivities, floor_m_s: float) -> None:
    """Print what 1 % more of each parameter changes; of an angle, what 1 deg more changes.

    At a kink less changes other things than more, and has a row of its own. A gait whose speed is
    below floor_m_s has none to take per cents of.
    """
    rows, travels = [], found.at[0] > floor_m_s
    for k, name in enumerate(found.names):
        angle = name.endswith("_rad") or "_rad[" in name
        step = math.radians(1) if angle else 0.01 * found.values[k]
        size = [*(100 * step / found.at[:3]), math.degrees(step)]
        size[0] = size[0] if travels else 1000 * step
        for sign in (-1, 1) if found.kinks[k] else (1,):
            by, known = found.derivatives[k], found.errors[k]
            if found.kinks[k]:
                by, known = (v[k, :, (sign + 1) // 2] for v in (found.sides, found.side_errors))
            changes = [
                f"{sign * v * one:+.2g}" if abs(v) > e else "0"
                for v, e, one in zip(by, known, size, strict=True)
            ]
            more = "" if sign > 0 else "-"
            label = name + (" (kink)" if found.kinks[k] else "")
            rows.append([label, more + ("1 deg" if angle else "1 %"), *changes])
    speed = "speed, %" if travels else "speed, mm/s"
    columns = ["parameter", "more by", speed, "power, %", "power+, %", "turn, deg"]
    table("what a little more of each changes; ideal joints, others kept", columns, rows)
    console.print("power+: without regeneration; turn: in a cycle")
    if found.kinks.any():
        console.print(
            "kink: at this point a wheel begins or ceases to rest, so a little less and a little "
            "more each have a row",
            highlight=False,
        )


def doubts(found: SpeedDoubts) -> None:
    """Print what makes a predicted speed's interval wide."""
    columns = ["uncertain", "by derivatives", "by draws"]
    table("what that leaves of the predicted speed, 1 sigma", columns, found.rows())
    console.print(found.in_words())


def warn(found: LeastPower | RobustGait) -> None:
    """Warn of samples that disagree, and of joints that turn faster than any servo does."""
    from ...gaits.robust import RobustGait

    if isinstance(found, RobustGait) and not found.confirmed:
        notices.print(
            "serpenoid: warning: the other samples disagree by more than chance; believe the lower "
            "of the two speeds"
        )
    rate = found.gait.alpha_rad * found.gait.omega_rad_s
    if rate > _FASTEST_SERVO_RAD_S:
        notices.print(
            f"serpenoid: warning: the joints would turn at up to {math.degrees(rate):.3g} deg/s, "
            "which no hobby servo does; --servo-speed-deg-s keeps to what yours do"
        )


def warn_of_cliff(found: Margins, sigmas: dict[str, float] | None = None) -> None:
    """Warn beside a cliff; sigmas: `Margins.in_sigmas`, with a fit."""
    known = {name: share for name, share in (sigmas or {}).items() if math.isfinite(share)}
    if known:
        told = ", ".join(f"{name.partition('_')[0]} {share:.2g}" for name, share in known.items())
        console.print(f"margins in standard deviations: {told}")
    if found.warning:
        notices.print(f"serpenoid: warning: {found.warning}")


def front(speeds_m_s: Sequence[float], found: Sequence[LeastPower | RobustGait | None]) -> None:
    """Print the least-power or robust gaits of many speeds."""
    cells = [
        [f"{speed:.4g}", *(_front_cells(best) if best else ["out of reach"])]
        for speed, best in zip(speeds_m_s, found, strict=True)
    ]
    heads = ["speed (m/s)", "W", "omega (rad/s)", "alpha (deg)", "beta (deg)", "limits reached"]
    if max(map(len, cells)) > len(heads):
        heads += ["95 % make (m/s)", "premium"]
    table("gaits of least power", heads, cells)


def _front_cells(best: LeastPower | RobustGait) -> list[str]:
    """Return power, gait and limits; of a robust gait what it keeps, and what that costs."""
    from ...gaits.robust import RobustGait

    gait = best.gait
    angles = [f"{math.degrees(angle):.4g}" for angle in (gait.alpha_rad, gait.beta_rad)]
    cells = [f"{best.power_w:.5g}", f"{gait.omega_rad_s:.4g}", *angles]
    cells.append(", ".join(best.active) or "none")
    if isinstance(best, RobustGait):
        cells += [f"{best.low_speed_m_s:.4g}", f"{100 * best.premium:.3g} %"]
    return cells
