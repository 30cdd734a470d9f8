"""Whether a gait is too fast for a servo: the one decision, and the sentence that states it."""

from __future__ import annotations

import math
from statistics import median

from ..model.drives import Servo, ServoKind
from ..model.gait import Gait

# Share of the no-load speed, where a servo has no torque left. Up to this share the speeds of a
# robot with servos of one kind spread by some 8 %, above it by a factor of 1.5 and more.
MAX_NO_LOAD_SHARE = 0.9


def joint_rate_rad_s(gait: Gait) -> float:
    """Return the fastest rate at which a gait turns a joint, rad/s."""
    return gait.alpha_rad * gait.omega_rad_s * max(gait.joint_gain or (1.0,))


def no_load_rad_s(servo: Servo | ServoKind) -> float:
    """Return the no-load speed of a servo, or of the typical one of a kind, at its voltage, rad/s.

    The typical one of a kind that was measured is the median of its samples.
    """
    servos = (servo,) if isinstance(servo, Servo) else servo.drawn or (servo.servo,)
    return float(median(each_servo.no_load_rad_s for each_servo in servos))


def highest_hz(gait: Gait, servo: Servo | ServoKind) -> float:
    """Return the frequency, Hz, up to which a gait of this shape is not too fast for a servo."""
    rate_rad_s = joint_rate_rad_s(gait)
    if rate_rad_s == 0.0:
        return math.inf
    limit_rad_s = MAX_NO_LOAD_SHARE * no_load_rad_s(servo)
    return limit_rad_s / rate_rad_s * gait.omega_rad_s / math.tau


def is_too_fast(gait: Gait, servo: Servo | ServoKind | None) -> bool:
    """Return whether the joints must turn faster than a servo can follow; None: ideal joints."""
    return servo is not None and gait.omega_rad_s > math.tau * highest_hz(gait, servo)


def too_fast_text(gait: Gait, servo: Servo | ServoKind | None, gait_name: str = "") -> str:
    """Return the sentence that a gait is too fast for a servo, or "" where it is not.

    gait_name: begins the sentence where several gaits are spoken of.
    """
    if servo is None or not is_too_fast(gait, servo):
        return ""
    rate_rad_s, free_rad_s = joint_rate_rad_s(gait), no_load_rad_s(servo)
    limit_rad_s = MAX_NO_LOAD_SHARE * free_rad_s
    apart = (d for d in range(2, 6) if f"{rate_rad_s:.{d}g}" != f"{limit_rad_s:.{d}g}")
    digits = next(apart, 6)
    highest = highest_hz(gait, servo)
    unit_hz = 10.0 ** (math.floor(math.log10(highest)) - 1)  # unit of its second digit
    too_fast = f"{gait_name} is too fast" if gait_name else "Too fast"
    name = f"a typical {servo.name} servo" if isinstance(servo, ServoKind) else "the given servo"
    return (
        f"{too_fast} for {name}: the joints must turn at {rate_rad_s:.{digits}g} rad/s; the limit "
        f"is {limit_rad_s:.{digits}g} ({100 * MAX_NO_LOAD_SHARE:.0f} % of its no-load speed, "
        f"{free_rad_s:.2g}). Stay below "
        f"{math.floor(1.005 * highest / unit_hz) * unit_hz:.2g} Hz."
    )
