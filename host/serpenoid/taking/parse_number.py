"""What a person types: numbers with units (comma decimals, grade, km/h), and cells.

A bare number is in the field's own unit. Where that is not what was expected but another unit
would be, that unit is named; nothing is refused but what cannot be.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from typing import Any

from ..base.errors import BadInput
from ..session.declaration import Field, Range, Word
from ..session.rows import kind_of
from ..session.settings import Setup

_FIRST = re.compile(
    r"([+-]?(?:\d+(?:[.,]\d*)?|[.,]\d+)(?:[eE][+-]?\d+)?)(?:\s*([^\s\d;,.+-][^\s;]*))?(?=[\s;]|$)[\s;]*"
)
_SPELLINGS = {
    "deg": "° degree degrees",
    "%": "percent",
    "km/h": "kmh kph km/hr",
    "m/s": "ms mps",
    "s": "sec secs",
    "min": "mins",
    "kg": "kgs",
    "g": "gr grams gram",
    "lb": "lbs",
    "in": "inch inches",
}


def first_number(text: str, field: Field, unit: str = "") -> tuple[float, str]:
    """Return a line's first number in the field's unit, and the rest of the line.

    unit: of a number without one, the field's own unless given. Raises BadInput with one sentence
    that says the way out.
    """
    text = text.strip().replace("−", "-")
    if not text and field.usual is not None:
        return field.usual, ""
    match = _FIRST.match(text)
    rest = "" if match is None else text[match.end() :]
    if match is None or (rest and not re.match(r"[+-]?[.,]?\d", rest)):
        raise BadInput(f"{text!r} is no number; {field.example}")
    named = _unit(match[2], field) if match[2] else unit or field.unit
    value = _converted(float(match[1].replace(",", ".")), named, field)
    if not field.low <= value <= field.high or (field.open_low and value == field.low):
        says = field.words if field.words.endswith("shows") else f"{field.words} is"
        raise BadInput(
            f"{value:.4g} {field.unit} cannot be: {says} {field.low:g} to {field.high:g} "
            f"{field.unit}; {field.example}"
        )
    return value, rest


def read_number(text: str, field: Field) -> float:
    """Return the number of an option or a cell; raises BadInput where its unit is in doubt."""
    value, rest = first_number(text, field)
    if rest:
        raise BadInput(f"{text!r} is more than one number; {field.example}")
    if re.search(r"\d[.,]?\s*$", text) and other_unit(value, field, field.likely):
        raise BadInput(f"{off_in_words(value, field, field.likely)}; type the unit, too")
    return value


def other_unit(value: float, field: Field, likely: Range | None, unit: str = "") -> str:
    """Return how a number would be likely in another unit; "" if in none, or if it is likely.

    unit: that it was taken in.
    """
    low, high = likely or (-math.inf, math.inf)
    unit = unit if unit in field.units else field.unit
    if not value or high == math.inf or low <= value <= high:
        return ""
    number = _typed_in(value, unit, field)
    others = {name: _converted(number, name, field) for name in field.units if name != unit}
    fitting = {name: x for name, x in others.items() if low <= x <= high}
    if not fitting:
        return ""
    middle = math.sqrt(max(low, 1e-3 * high) * high)
    best = min(fitting, key=lambda name: abs(math.log(max(abs(fitting[name]), 1e-12) / middle)))
    return f"{number:.4g} {best} would be {fitting[best]:.4g} {field.unit}"


def off_in_words(value: float, field: Field, likely: Range | None, unit: str = "") -> str:
    """Return a number that is not where it was expected, and what else may have been meant."""
    low, high = likely or (-math.inf, math.inf)
    span = f"at least {low:.3g}" if high == math.inf else f"{low:.3g} to {high:.3g}"
    meant = other_unit(value, field, likely, unit)
    why = "; ".join(filter(None, (meant, field.why)))
    text = f"{field.words} {value:.4g} {field.unit}: expected {span}"
    return f"{text} ({why})" if why else text


def _unit(text: str, field: Field) -> str:
    for unit in field.units:
        if text.lower() in (unit.lower(), *_SPELLINGS.get(unit, "").split()):
            return unit
    raise BadInput(f"{text!r} is no unit of this; {field.example}")


def _converted(number: float, unit: str, field: Field) -> float:
    if (field.unit, unit) == ("deg", "%"):
        return math.degrees(math.atan(number / 100))
    if (field.unit, unit) == ("%", "deg"):
        return 100 * math.tan(math.radians(number))
    return number * field.units[unit]


def _typed_in(value: float, unit: str, field: Field) -> float:
    """Return the number that stands for a value in a unit."""
    if (field.unit, unit) == ("deg", "%"):
        return 100 * math.tan(math.radians(value))
    return value / (field.units[unit] or 1.0)


def read_cells(kind: str, cells: Iterable[str], setup: Setup) -> dict[str, Any]:
    """Return the values of one reading from NAME=VALUE pairs, derived ones too; raises BadInput."""
    columns = [field.column for field in kind_of(kind).declared.values()]
    typed = dict[str, str]()
    for cell in cells:
        name, equals, text = cell.partition("=")
        if not equals or name not in columns:
            raise BadInput(f"{cell!r} is not NAME=VALUE with a name of {', '.join(columns)}")
        if name in typed:
            raise BadInput(f"{name} is given twice; give it once")
        typed[name] = text
    words = {f.column: f.read for f in kind_of(kind).declared.values() if isinstance(f, Word)}
    read = {c: words[c](text) if c in words else text for c, text in typed.items()}
    return completed(kind, typed_cells(kind, read), setup)


def typed_cells(kind: str, typed: Mapping[str, Any]) -> dict[str, Any]:
    """Return what was typed by column, numbers in text read with their units."""
    numbers = kind_of(kind).numbers()
    return {
        column: read_number(value, numbers[column])
        if isinstance(value, str) and column in numbers
        else value
        for column, value in typed.items()
    }


def completed(kind: str, cells: Mapping[str, Any], setup: Setup) -> dict[str, Any]:
    """Return a reading's values with what an empty answer means, and what follows from others."""
    usual = {
        column: field.usual
        for column, field in kind_of(kind).numbers().items()
        if field.usual is not None and not field.optional  # what was not said is not known
    }
    return kind_of(kind).derived(usual | dict(cells), setup.instruments)
