"""Values checked where they enter: what is wrong, its limits, and its name."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple, SupportsIndex

from .errors import BadInput

# What is made of numbers (squares, quotients, products of several) must be finite as well. No
# robot is larger than the universe (1e27 m) or lighter than an electron (1e-30 kg).
LARGEST, SMALLEST = 1e30, 1e-30

CHOICES = {  # The words that a scene takes, by the names of its fields
    "formulation": ("explicit", "implicit"),
    "drive": ("angle", "torque", "servo"),
    "start": ("link1_at_rest", "zero_momentum", "steady"),
    "gap": ("slow_manifold", "zero"),
    "record": ("joints", "friction", "energy"),
}


def check_number(
    name: str,
    value: object,
    low: float = -math.inf,
    high: float = math.inf,
    open_low: bool = False,
) -> float:
    """Return value as a float, or raise BadInput naming it and the range it must be in.

    Without limits of its own it is at most 1e30 in magnitude; open_low, at least 1e-30 above low.
    """
    number = value if type(value) is float else _as_float(value)
    lowest, highest = max(low, -LARGEST), min(high, LARGEST)
    first = lowest + SMALLEST if open_low else lowest
    if number is not None and first <= number <= highest and (number > lowest or not open_low):
        return number
    rule = range_in_words(low, high, open_low)
    if number is None:
        raise BadInput(f"{name} is {value!r}; it must be {rule}")
    beyond = math.isfinite(number) and (abs(number) > LARGEST or 0 < abs(number) < SMALLEST)
    rule += f", and {SMALLEST:g} to {LARGEST:g} in magnitude" if beyond else ""
    raise BadInput(f"{name} is {number!r}; it must be {rule}")


class Limits(NamedTuple):
    """The ends of a number's range; open_low: the lower one is not in it."""

    low: float = -math.inf
    high: float = math.inf
    open_low: bool = False


POSITIVE, NOT_NEGATIVE = Limits(0.0, open_low=True), Limits(0.0)


def check_fields(part: object, table: Mapping[str, Limits]) -> None:
    """Hold a frozen dataclass's fields as floats, each within its limits, or raise BadInput."""
    for name, limits in table.items():
        object.__setattr__(part, name, check_number(name, getattr(part, name), *limits))


def _as_float(value: object) -> float | None:
    """Return a number as a float, and None for what is none."""
    if isinstance(value, (bool, str, bytes)):
        return None
    try:
        return float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError, OverflowError):  # an int may have 400 digits
        return None


def range_in_words(low: float, high: float, open_low: bool) -> str:
    """Say what numbers are allowed, such as 'a finite number, at least 0'."""
    limits = f"{'more than' if open_low else 'at least'} {low:g}" if low > -math.inf else ""
    if high < math.inf:
        limits += f"{' and ' if limits else ''}at most {high:g}"
    return f"a finite number{', ' + limits if limits else ''}"


def count_text(count: int, noun: str) -> str:
    """Return a count with its noun, such as `1 reading` or `2 pushes`."""
    plural = "es" if noun.endswith("sh") else "s"
    return f"{count} {noun}{plural * (count != 1)}"


def check_kind(name: str, value: object, *kinds: type, order: str = "") -> None:
    """Raise BadInput unless value is of a kind; order: of the arguments, for swapped ones."""
    if not isinstance(value, kinds):
        names = " or ".join(f"serpenoid.{k.__name__}" for k in kinds)
        order = f": the order is {order}" if order else ""
        raise BadInput(f"{name} is a {type(value).__name__}; it must be a {names}{order}")


def check_choice(name: str, value: object, choices: tuple[str, ...] = ()) -> str:
    """Return value if it is one of the choices, or raise BadInput listing them.

    choices: those of the field of a scene with this name, unless given.
    """
    choices = choices or CHOICES[name]
    if not isinstance(value, str) or value not in choices:
        raise BadInput(f"{name} is {value!r}; it must be one of {', '.join(choices)}")
    return value


def check_text(name: str, value: object, blank: bool = False) -> str:
    """Return a text without space about it, or raise BadInput; blank: it may be empty."""
    if not isinstance(value, str) or not (blank or value.strip()):
        raise BadInput(f"{name} is {value!r}; it must be text in quotes")
    return value.strip()


def check_whole(name: str, value: object, low: int, high: int | None = None) -> int:
    """Return a whole number, or raise BadInput naming it and the range it must be in."""
    number = None
    if isinstance(value, SupportsIndex) and not isinstance(value, bool):
        with suppress(TypeError):  # An array is no index, though it has the method.
            number = value.__index__()
    if number is None or not low <= number <= (math.inf if high is None else high):
        ends = f", {low} or more" if high is None else f" from {low} to {high}"
        raise BadInput(f"{name} is {value!r}; it must be a whole number{ends}")
    return number


def sha256_of(path: Path) -> str:
    """Return a file's SHA-256 in hexadecimal digits; read in blocks, as films are large."""
    done = hashlib.sha256()
    with path.open("rb") as file:
        while block := file.read(1 << 20):
            done.update(block)
    return done.hexdigest()
