"""Numbers and names as the wire takes them."""

from __future__ import annotations

import math
import re

from ...model.errors import BadInput


def digits(value: float) -> str:
    """Write a number as the wire takes it: at most 6 decimals, no exponent."""
    if not math.isfinite(value):
        raise BadInput(f"{value} cannot be sent; every number must be finite")
    text = f"{value:.6f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


def degrees(angle_rad: float) -> str:
    """Write an angle in degrees."""
    return digits(math.degrees(angle_rad))


def word(name: str) -> str:
    """Return a name of the protocol's form, or raise BadInput."""
    if not re.fullmatch(r"[a-z_]+", name):
        raise BadInput(f"{name!r} is no name of a setting or field; see firmware/PROTOCOL.md")
    return name
