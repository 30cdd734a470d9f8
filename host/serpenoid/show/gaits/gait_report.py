"""What the command line says of optima: their error, limits and losses."""

from __future__ import annotations

from ...gaits.least_power import LeastPower
from ...gaits.limits import LIMITS, REACHED
from ...model.drives import Servo, ServoKind
from ...model.gait import gait_name
from ...servos.speed_limit import is_too_fast


def beside_ideal(best: LeastPower, ideal: LeastPower, servo: Servo | ServoKind | None) -> str:
    """Return what limits a gait, and what the optimum without limits would cost and risk."""
    active = [name for name in best.active if name != LIMITS["kept_speed_share"][0]]
    words = f"Limited by {', '.join(active)}. " if active else ""
    kept_share = best.limits.kept_speed_share
    if 1 - best.losses.worst < kept_share * (1 - REACHED):
        words += f"No gait keeps {100 * kept_share:.0f} % of its speed; this one loses least. "
    less = 1 - ideal.power_w / best.power_w
    if less < REACHED:
        return f"{words}Without these limits no gait takes noticeably less."
    speed = "is too fast for the servos and " if is_too_fast(ideal.gait, servo) else ""
    return (
        f"{words}The paper's optimum, {gait_name(ideal.gait)}, takes {100 * less:.2g} % less "
        f"power; it {speed}loses {ideal.losses.in_words()}."
    )
