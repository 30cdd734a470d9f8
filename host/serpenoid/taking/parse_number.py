"""Parse what a person types: numbers with units, such as 2,3 deg, 4 % or 1.6 km/h, and cells.

A number without a unit is in the field's own unit; a belt's speed is in that of the treadmill.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from typing import Any

from ..base.errors import BadInput
from ..session.declaration import Field, Range, Units
from ..session.folder import kind_of
from ..session.settings import Setup

SPELLINGS = {  # Unit -> other spellings of it, by people and programs.
    "deg": "° degree degrees",
    "%": "percent",
    "km/h": "kmh kph km/hr",
    "m/s": "ms mps",
    "m": "meter meters metre metres м",
    "cm": "centimeter centimeters centimetre centimetres см",
    "mm": "millimeter millimeters millimetre millimetres мм",
    "in": 'inch inches "',
    "ft": "foot feet",
    "yd": "yard yards",
    "s": "sec secs second seconds с сек",
    "ms": "msec millisecond milliseconds мс 毫秒",
    "μs": "us microsecond microseconds",
    "min": "mins",
    "kg": "kgs",
    "g": "gr grams gram",
    "lb": "lbs",
}


def spelled_unit(text: str, units: Units) -> str:
    """Return the unit that a text names, "" if it is none of units."""
    spelled = text.casefold()
    for unit in units:
        if spelled in (unit.casefold(), *SPELLINGS.get(unit, "").split()):
            return unit
    return ""


def bare_unit(field: Field, belt_unit: str) -> str:
    """Return the unit of a number that is typed without one.

    belt_unit: unit that the treadmill shows; "" if unknown.
    """
    return belt_unit if belt_unit and field.column.startswith("belt_speed") else field.unit


def first_number(text: str, field: Field, belt_unit: str = "") -> tuple[float, str]:
    """Return a line's first number in the field's unit, and the rest of the line.

    Raises BadInput, with a sentence on what to type, if there is no number, or if it is outside the
    field's limits.
    """
    text = text.strip().replace("−", "-")
    if not text and field.usual is not None:
        return field.usual, ""
    number, unit_text = r"[+-]?(?:\d+(?:[.,]\d*)?|[.,]\d+)(?:[eE][+-]?\d+)?", r"[^\s\d;,.+-][^\s;]*"
    match = re.match(rf"({number})(?:\s*({unit_text}))?(?=[\s;]|$)[\s;]*", text)
    remainder = "" if match is None else text[match.end() :]
    if match is None or (remainder and not re.match(r"[+-]?[.,]?\d", remainder)):
        raise BadInput(f"{text!r} is no number; {field.example}")
    unit = spelled_unit(match[2], field.units) if match[2] else bare_unit(field, belt_unit)
    if match[2] and not unit:
        raise BadInput(f"{match[2]!r} is neither a number nor a unit of this; {field.example}")
    value = _converted(float(match[1].replace(",", ".")), unit, field)
    if not field.low <= value <= field.high or (field.open_low and value == field.low):
        raise BadInput(
            f"{value:.4g} {field.unit} cannot be: {field.words}, {field.low:g} to {field.high:g} "
            f"{field.unit}; {field.example}"
        )
    return value, remainder


def read_number(text: str, field: Field) -> float:
    """Return an option's or a cell's number in the field's unit; raises BadInput.

    A doubtful number must have its unit.
    """
    value, remainder = first_number(text, field)
    if remainder:
        raise BadInput(f"{text!r} is more than one number; {field.example}")
    low, high = field.likely or (-math.inf, math.inf)
    if text.rstrip()[-1:].isdigit() and not low <= value <= high:
        raise BadInput(f"{doubt_in_words(value, field, (low, high))}; type the unit too")
    return value


def doubt_in_words(value: float, field: Field, likely: Range) -> str:
    """Return a sentence on a number outside the range where it is expected."""
    why = f" ({field.why})" if field.why else ""
    name = field.words.partition(" (")[0]
    span = f"{likely[0]:.3g} to {likely[1]:.3g} {field.unit}"
    return f"{name}: {value:.4g} {field.unit}; expected {span}{why}"


def _converted(number: float, unit: str, field: Field) -> float:
    if (field.unit, unit) == ("deg", "%"):
        return math.degrees(math.atan(number / 100))
    if (field.unit, unit) == ("%", "deg"):
        return 100 * math.tan(math.radians(number))
    return number * field.units[unit]


def typed_cells(kind: str, typed: Mapping[str, Any], setup: Setup) -> dict[str, Any]:
    """Return a reading's cells, column -> value, from typed ones; raises BadInput.

    typed: numbers may be texts with units. Columns that are not typed get their usual value, and
    those that follow from others are added.
    """
    values = dict(typed)
    for field in kind_of(kind).declared.values():
        text = typed.get(field.column)
        if field.is_number and isinstance(text, str):
            values[field.column] = read_number(text, field)
        elif field.usual is not None and not field.optional:
            values.setdefault(field.column, field.usual)  # An optional column stays empty.
    return kind_of(kind).derived(values, setup.instruments)
