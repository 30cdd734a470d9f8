"""What a person types: numbers with units (comma decimals, grade, km/h), and cells.

A bare number is in the field's own unit. Where that is not what was expected but another unit
would be, the answer comes with a question; nothing is refused but what cannot be.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from ..base.errors import BadInput
from ..session.declaration import Field, Range, Word
from ..session.kinds import KINDS, kind_of
from ..session.settings import Setup

# Other names of columns, by which people type another unit: name -> column, unit.
OTHER_UNITS = {
    f.other_unit[0]: (column, f.other_unit[1])
    for kind in KINDS.values()
    for column, f in kind.numbers().items()
    if f.other_unit
}
OTHER_UNITS |= {"incline_percent": ("incline_deg", "%"), "drift_km_h": ("drift_m_s", "km/h")}
_NUMBER = re.compile(r"([+-]?(?:\d+(?:[.,]\d*)?|[.,]\d+)(?:[eE][+-]?\d+)?)\s*(\S*)")
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


@dataclass(frozen=True)
class Typed:
    """A number in the field's unit; question, if not empty, is to be asked before it is taken.

    meant: the value if the question is answered by yes.
    """

    value: float
    question: str = ""
    meant: float | None = None


def parse_number(text: str, field: Field, likely: Range | None = None, unit: str = "") -> Typed:
    """Read a number with or without unit; raises BadInput with one sentence that says the way out.

    likely: the range expected now, the field's own unless given. unit: of a number without one, the
    field's own unless given.
    """
    text = text.strip()
    if not text and field.usual is not None:
        return Typed(field.usual)
    match = _NUMBER.fullmatch(text.replace("−", "-"))
    if not match:
        raise BadInput(f"{text!r} is no number; {field.example}")
    number = float(match[1].replace(",", "."))
    if match[2]:
        return Typed(_checked(_converted(number, _unit(match[2], field), field), field))
    unit = unit or field.unit
    value = number if unit == field.unit else _converted(number, unit, field)
    low, high = likely or field.likely or (-math.inf, math.inf)
    if number and high < math.inf and not low <= value <= high:
        others = {other: _converted(number, other, field) for other in field.units if other != unit}
        in_range = {other: x for other, x in others.items() if low <= x <= high}
        if in_range:
            other = min(in_range, key=lambda name: _off_middle(in_range[name], (low, high)))
            question = (
                f"{number:g} {unit} is outside {span((low, high))} {field.unit}; "
                f"did you mean {number:g} {other} = {in_range[other]:.4g} {field.unit}?"
            )
            return Typed(value, question, in_range[other])
    return Typed(_checked(value, field))


def _off_middle(value: float, likely: Range) -> float:
    """Return how far a value is from the geometric middle of a range, in factors of e."""
    low, high = likely
    middle = math.sqrt(max(low, 1e-3 * high) * high)
    return abs(math.log(max(abs(value), 1e-12) / middle))


def span(likely: Range) -> str:
    """Return a range in words."""
    low, high = likely
    return f"at least {low:.3g}" if high == math.inf else f"{low:.3g} to {high:.3g}"


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


def _checked(value: float, field: Field) -> float:
    if not field.low <= value <= field.high or (field.open_low and value == field.low):
        says = field.words if field.words.endswith("shows") else f"{field.words} is"
        raise BadInput(
            f"{value:.4g} {field.unit} cannot be: {says} {field.low:g} to {field.high:g} "
            f"{field.unit}; {field.example}"
        )
    return value


def read_cells(kind: str, cells: Iterable[str], setup: Setup) -> dict[str, Any]:
    """Return the values of one reading from NAME=VALUE pairs, derived ones too; raises BadInput."""
    columns = [field.column for field in kind_of(kind).fields]
    pairs: list[tuple[str, str]] = []
    for cell in cells:
        name, equals, text = cell.partition("=")
        if not equals or OTHER_UNITS.get(name, (name,))[0] not in columns:
            others = {column: f"{column} (or {name})" for name, (column, _) in OTHER_UNITS.items()}
            names = ", ".join(others.get(column, column) for column in columns)
            raise BadInput(f"{cell!r} is not NAME=VALUE with a name of {names}")
        pairs.append((name, text))
    words = {f.column: f.read for f in kind_of(kind).fields if isinstance(f, Word)}
    typed = typed_cells(kind, pairs)
    typed |= {column: read(typed[column]) for column, read in words.items() if column in typed}
    return completed(kind, typed, setup)


def typed_cells(kind: str, typed: Iterable[tuple[str, Any]]) -> dict[str, Any]:
    """Return what was typed by column, numbers read with their units.

    A name of another unit puts this unit behind a bare number. Raises BadInput where one column is
    given twice, by whichever names.
    """
    numbers = kind_of(kind).numbers()
    names, cells = dict[str, str](), dict[str, Any]()
    for name, value in typed:
        column, unit = OTHER_UNITS.get(name, (name, ""))
        if column not in numbers:
            column, unit = name, ""
        if column in names:
            both = " and ".join(dict.fromkeys((names[column], name)))
            raise BadInput(f"{both}: one quantity is given twice; give it once")
        names[column] = name
        bare = unit and not re.search(r"[^\W\d_]$|%$", str(value).strip())
        typed_value = f"{value} {unit}" if bare else value
        if isinstance(typed_value, str) and column in numbers:
            parsed = parse_number(typed_value, numbers[column])
            if parsed.question:
                raise BadInput(f"{column}: {parsed.question} Type the unit, too")
            typed_value = parsed.value
        cells[column] = typed_value
    return cells


def completed(kind: str, cells: Mapping[str, Any], setup: Setup) -> dict[str, Any]:
    """Return a reading's values with what an empty answer means, and what follows from others."""
    usual = {
        column: field.usual
        for column, field in kind_of(kind).numbers().items()
        if field.usual is not None and not field.optional  # what was not said is not known
    }
    return kind_of(kind).derived(usual | dict(cells), setup.instruments)
