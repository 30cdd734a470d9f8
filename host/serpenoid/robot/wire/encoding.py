"""Numbers and names as the wire takes them, and as a board can say them."""

from __future__ import annotations

import math
import numbers
import re

from ...base.errors import BadInput, DamagedLine

NUMBER = re.compile(r"-?\d{1,10}(\.\d{1,6})?", re.ASCII)
CAN_BE_OFF = ("silence", "limp")
MOST_SENT = 1e9  # the board's own limits are lower, and told by it
FARTHEST_DEG = 180.0  # beyond any joint's limits
MOST_COUNT = 2**32 - 1
PULSES_US = range(500, 2501)


def digits(value: float) -> str:
    """Write a number as the wire takes it: at most 6 decimals, no exponent. Raises BadInput."""
    number = isinstance(value, numbers.Real)
    if not number or not -MOST_SENT <= value <= MOST_SENT:  # NaN and integers beyond any float, too
        shown = "an integer" if isinstance(value, int) else repr(value)[:40]
        raise BadInput(
            f"{shown} cannot be sent; it must be a number, finite and at most {MOST_SENT:g} in size"
        )
    text = f"{value:.6f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


def degrees(angle_rad: float) -> str:
    """Write an angle in degrees."""
    return digits(math.degrees(angle_rad))


def said(name: str, text: str, low: float, high: float) -> float:
    """Return a number that a board said, or raise DamagedLine if it can say no such number."""
    if not NUMBER.fullmatch(text) or not low <= float(text) <= high:
        raise DamagedLine(
            f"{name} is {text[:40]!r}; a board says a number from {low:g} to {high:g}"
        )
    return float(text)


def said_count(name: str, text: str, low: int = 0, high: int = MOST_COUNT) -> int:
    """Return a whole number that a board said, of 32 bits unless it has other limits."""
    return int(said(name, text, low, high))


def said_field(fields: dict[str, tuple[str, float, float, float]], name: str, text: str) -> float:
    """Return the value of a setting or trim, within the limits that the firmware has for it."""
    if name not in fields:
        return said(name, text, -2147.0, 2147.0)  # of a newer firmware of this protocol
    _, low, high, _ = fields[name]
    off = name in CAN_BE_OFF and text == "0"
    return 0.0 if off else said(name, text, low, high)


def check_frame(
    setpoint_rad: tuple[float, ...], pulse_us: tuple[int, ...], phase_rad: float
) -> None:
    """Raise DamagedLine for a frame that no board can send, however right its CRC is."""
    if any(abs(angle) > math.radians(FARTHEST_DEG) for angle in setpoint_rad):
        raise DamagedLine(f"a setpoint is beyond {FARTHEST_DEG:g} degrees")
    if any(pulse and pulse not in PULSES_US for pulse in pulse_us):
        raise DamagedLine(f"pulses are {pulse_us}; a board sends 0 or 500 to 2500 us")
    if not 0.0 <= phase_rad <= 2 * math.pi:
        raise DamagedLine(f"the phase is {math.degrees(phase_rad):.0f} degrees; a turn has 360")
