"""Values checked where they enter: what is wrong, its limits, and its name."""

from __future__ import annotations

import math

from .errors import BadInput


def check_number(
    name: str,
    value: object,
    low: float = -math.inf,
    high: float = math.inf,
    *,
    open_low: bool = False,
) -> float:
    """Return value as a float, or raise BadInput naming it and the range it must be in."""
    limits = f"{'more than' if open_low else 'at least'} {low:g}" if low > -math.inf else ""
    if high < math.inf:
        limits += f"{' and ' if limits else ''}at most {high:g}"
    rule = f"a finite number{', ' + limits if limits else ''}"
    if isinstance(value, (bool, str, bytes)):
        raise BadInput(f"{name} is {value!r}; it must be {rule}")
    try:
        number = float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError, OverflowError):  # an int may have 400 digits
        raise BadInput(f"{name} is {value!r}; it must be {rule}") from None
    inside = (number > low if open_low else number >= low) and number <= high
    if not (math.isfinite(number) and inside):
        raise BadInput(f"{name} is {number!r}; it must be {rule}")
    return number


def check_choice(name: str, value: object, choices: tuple[str, ...]) -> str:
    """Return value if it is one of the choices, or raise BadInput listing them."""
    if not isinstance(value, str) or value not in choices:
        raise BadInput(f"{name} is {value!r}; it must be one of {', '.join(choices)}")
    return value
