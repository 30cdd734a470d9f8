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
    from ...model.gait import Gait
    from ...periodic.sensitivities import Sensitivities


def _percent(fraction: float) -> str:
    """Return a fraction as percent, with words where it has no number."""
    if math.isnan(fraction):
        return "no dry friction"
    return "more than 60 %" if math.isinf(fraction) else f"{100 * fraction:.3g} %"


def _lost(fraction: float) -> str:
    """Return a loss as percent; a negative one is a gain."""
    return f"none: {_percent(-fraction)} gained" if fraction < -5e-4 else _percent(fraction)


def cheapest(found: LeastPower | RobustGait) -> str:
    """Return the gait that a search chose, in the words of a builder."""
    gait = found.gait
    alpha, beta = math.degrees(gait.alpha_rad), math.degrees(gait.beta_rad)
    return (
        f"The gait of least power: {alpha:.0f}°/{beta:.0f}° at "
        f"{gait.omega_rad_s / math.tau:.2g} Hz, {found.power_w:.2g} W."
    )


def optimum(found: LeastPower) -> None:
    """Print what is known of an optimum."""
    rows = [
        [f"least {found.cost}", f"{found.power_w:.6g} W"],
        ["its own error, estimated", f"{found.solved_error_w:.1g} W"],
        ["some gait may need less, by up to", f"{found.power_error_w:.1g} W"],
        ["limits reached", ", ".join(found.active) or "none"],
        ["valleys of shapes followed", f"{found.basins}"],
    ]
    if math.isfinite(found.runner_up_w):
        rows.append(["next best valley", f"{found.runner_up_w:.6g} W"])
    table("the optimum", ["", "value"], rows)


_FASTEST_SERVO_RAD_S = 30.0  # no load, the fastest that hobbyists can buy; common ones make 5 to 10


def no_servo(gait: Gait) -> None:
    """Warn of joints that turn faster than any servo does."""
    rate = gait.alpha_rad * gait.omega_rad_s
    if rate > _FASTEST_SERVO_RAD_S:
        notices.print(
            f"serpenoid: warning: the joints would turn at up to {math.degrees(rate):.3g} deg/s, "
            "which no hobby servo does; --servo-speed-deg-s keeps to what yours do"
        )


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
    console.print("power+: without regeneration; turn: in a cycle", highlight=False)
    if found.kinks.any():
        console.print(
            "kink: at this point a wheel begins or ceases to rest, so a little less and a little "
            "more each have a row",
            highlight=False,
        )


def doubts(found: SpeedDoubts) -> None:
    """Print what makes a predicted speed's interval wide."""
    columns = ["in doubt", "by derivatives", "by draws"]
    table("what that leaves of the predicted speed, 1 sigma", columns, found.rows())
    console.print(found.in_words(), highlight=False)


def robust(found: RobustGait) -> None:
    """Print what robustness gives, and what it costs."""
    rows = [
        ["wanted speed", f"{found.wanted_m_s:.4g} m/s"],
        ["95 % of the sampled robots are faster than", f"{found.low_speed_m_s:.4g} m/s"],
        ["the same, of other samples", f"{found.checked_low_m_s:.4g} m/s"],
        ["standard error of either", f"{found.low_error_m_s:.2g} m/s"],
        [f"{found.cost}", f"{found.power_w:.4g} W"],
        ["more than the least-power gait's", f"{100 * found.premium:.3g} %"],
        ["the same for each metre", f"{100 * found.premium_per_metre:.3g} %"],
        ["95 % of the robots with that gait make", f"{found.fragile_low_m_s:.4g} m/s"],
        ["limits reached", ", ".join(found.active) or "none"],
    ]
    table("robust gait", ["", "value"], rows)
    if not found.confirmed:
        notices.print(
            "serpenoid: warning: the other samples disagree by more than chance; believe the lower "
            "of the two speeds"
        )
    console.print(f"taken as uncertain: {found.uncertainty.in_words()}", highlight=False)


def margins(found: Margins, sigmas: dict[str, float] | None = None) -> None:
    """Print how far the cliff is, and warn beside it; sigmas: `Margins.in_sigmas`, with a fit."""
    rows = [
        ["amplitude may fall by, for a tenth of the speed", _percent(found.amplitude)],
        ["fn0 may fall by, for a tenth of the speed", _percent(found.grip)],
        ["speed lost with 10 % less amplitude", _lost(found.amplitude_loss)],
        ["speed lost with 13 % less dry friction across (fn0)", _lost(found.grip_loss)],
    ]
    columns = ["", "value"]
    if sigmas is not None:
        columns.append("in sigmas")
        known = [f"{share:.2g}" if math.isfinite(share) else "" for share in sigmas.values()]
        rows = [[*row, told] for row, told in zip(rows, [*known, "", ""], strict=True)]
    if found.travels:
        table("margins", columns, rows)
    if found.warning:
        notices.print(f"serpenoid: warning: {found.warning}")


def front(speeds_m_s: Sequence[float], found: Sequence[LeastPower | RobustGait | None]) -> None:
    """Print the least-power or robust gaits of many speeds."""
    from ...gaits.robust import RobustGait

    rows = []
    for speed, best in zip(speeds_m_s, found, strict=True):
        if best is None:
            rows.append([f"{speed:.4g}", "out of reach", "", "", "", ""])
            continue
        gait = best.gait
        rows.append(
            [
                f"{speed:.4g}",
                f"{best.power_w:.5g}",
                f"{gait.omega_rad_s:.4g}",
                f"{math.degrees(gait.alpha_rad):.4g}",
                f"{math.degrees(gait.beta_rad):.4g}",
                ", ".join(best.active) or "none",
            ]
        )
    columns = ["speed (m/s)", "W", "omega (rad/s)", "alpha (deg)", "beta (deg)", "limits reached"]
    if any(isinstance(best, RobustGait) for best in found):
        columns[-1:] = ["95 % make (m/s)", "premium", columns[-1]]
        for row, best in zip(rows, found, strict=True):
            kept = (
                [f"{best.low_speed_m_s:.4g}", f"{100 * best.premium:.3g} %"]
                if isinstance(best, RobustGait)
                else ["", ""]
            )
            row[-1:] = [*kept, row[-1]]
        table("robust gait for each speed", columns, rows)
        return
    table("least power at each speed", columns, rows)
