"""Numbers and names as the wire takes them, and as a board can say them."""

from __future__ import annotations

import math
import numbers
import re

from ...base.errors import BadInput, DamagedLine

MOST_COUNT = 2**32 - 1


def digits(value: float) -> str:
    """Write a number as the wire takes it: at most 6 decimals, no exponent. Raises BadInput."""
    number, largest = isinstance(value, numbers.Real), 1e9  # The board's own limits are lower.
    if not number or not -largest <= value <= largest:  # NaN and integers beyond any float, too
        shown = "an integer" if isinstance(value, int) else repr(value)[:40]
        raise BadInput(
            f"{shown} cannot be sent; it must be a number, finite and at most {largest:g} in size"
        )
    text = f"{value:.6f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


def degrees(angle_rad: float) -> str:
    """Write an angle in degrees."""
    return digits(math.degrees(angle_rad))


def number_in(name: str, text: str, low: float = -MOST_COUNT, high: float = MOST_COUNT) -> float:
    """Return a number that a board said, or raise DamagedLine if it can say no such number."""
    is_number = re.fullmatch(r"-?\d{1,10}(\.\d{1,6})?", text, re.ASCII)
    if not is_number or not low <= float(text) <= high:
        raise DamagedLine(
            f"{name} is {text[:40]!r}; a board says a number from {low:g} to {high:g}"
        )
    return float(text)


def count_in(name: str, text: str, low: int = 0, high: int = MOST_COUNT) -> int:
    """Return a whole number that a board said, of 32 bits unless it has other limits."""
    return int(number_in(name, text, low, high))
