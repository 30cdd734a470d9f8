"""What a person types, with its unit: comma decimals, degrees or grade, km/h or m/s.

A bare number is in the field's own unit. Where that is not what was expected but another unit
would be, the answer comes with a question; nothing is refused but what cannot be.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

from ....model.errors import BadInput
from ..steps import UNITS, Field

_NUMBER = re.compile(r"([+-]?(?:\d+(?:[.,]\d*)?|[.,]\d+))\s*(\S*)")
_SPELLINGS = {
    "°": "deg", "degree": "deg", "degrees": "deg", "percent": "%", "kmh": "km/h", "kph": "km/h",
    "km/hr": "km/h", "ms": "m/s", "mps": "m/s", "sec": "s", "secs": "s", "mins": "min",
    "kgs": "kg", "gr": "g", "grams": "g", "gram": "g", "lbs": "lb", "inch": "in", "inches": "in",
}  # fmt: skip


@dataclass(frozen=True)
class Typed:
    """A number in the field's unit; question, if not empty, is to be asked before it is taken.

    meant: the value if the question is answered by yes.
    """

    value: float
    question: str = ""
    meant: float | None = None


def read_typed(text: str, field: Field, likely: tuple[float, float] | None = None) -> Typed:
    """Read a number with or without unit; raises BadInput with one sentence that says the way out.

    likely: the range expected now, the field's own unless given.
    """
    text = text.strip()
    if not text and field.usual is not None:
        return Typed(field.usual)
    found = _NUMBER.fullmatch(text.replace("−", "-"))
    if not found:
        raise BadInput(f"{text!r} is no number; {_example(field)}")
    number = float(found[1].replace(",", "."))
    if found[2]:
        return Typed(_checked(_converted(number, _unit(found[2], field), field), field))
    return _bare(number, field, likely or field.likely)


def _bare(number: float, field: Field, likely: tuple[float, float] | None) -> Typed:
    """Judge a number without a unit by the range it was expected in."""
    inside = likely is None or likely[0] <= number <= likely[1]
    if inside and field.low <= number <= field.high:
        return Typed(number)
    for unit in list(UNITS[field.kind])[1:]:
        other = _converted(number, unit, field)
        if likely is not None and number and likely[0] <= other <= likely[1]:
            return Typed(
                number,
                f"{number:g} {field.unit} is outside {span(likely)} {field.unit}; "
                f"did you mean {number:g} {unit} = {other:.4g} {field.unit}?",
                other,
            )
    return Typed(_checked(number, field))


def span(likely: tuple[float, float]) -> str:
    """Return a range in words."""
    return f"{likely[0]:.3g} to {likely[1]:.3g}"


def _unit(text: str, field: Field) -> str:
    units = {unit.lower(): unit for unit in UNITS[field.kind]}
    unit = _SPELLINGS.get(text.lower(), text.lower())
    if unit not in units:
        raise BadInput(f"{text!r} is no unit of this; {_example(field)}")
    return units[unit]


def _converted(number: float, unit: str, field: Field) -> float:
    if field.kind == "incline" and unit == "%":
        return math.degrees(math.atan(number / 100))
    if field.kind == "grade" and unit == "deg":
        return 100 * math.tan(math.radians(number))
    return number * UNITS[field.kind][unit]


def _checked(value: float, field: Field) -> float:
    if not field.low <= value <= field.high:
        says = field.words if field.words.endswith("shows") else f"{field.words} is"
        raise BadInput(
            f"{value:.4g} {field.unit} cannot be: {says} {field.low:g} to {field.high:g} "
            f"{field.unit}; {_example(field)}"
        )
    return value


def _example(field: Field) -> str:
    if field.kind == "count":
        return "type a number, such as 6"
    units = " or ".join(UNITS[field.kind])
    return f"type a number in {units}, such as {_SAMPLES[field.kind]}"


_SAMPLES = {"incline": "2.3 or 4 %", "angle": "150", "speed": "0.45 or 1.6 km/h",
            "length": "1.2 or 76 mm", "rate": "3.14 or 0.5 Hz", "time": "9.5",
            "mass": "0.48 or 480 g", "grade": "0.5", "belt": "0.1"}  # fmt: skip
