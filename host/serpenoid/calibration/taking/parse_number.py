"""What a person types: numbers with units (comma decimals, grade, km/h), cells, amendments.

A bare number is in the field's own unit. Where that is not what was expected but another unit
would be, the answer comes with a question; nothing is refused but what cannot be.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from ...model.errors import BadInput
from ..kinds.declaration import DERIVED, UNITS, Field, Range
from ..kinds.rows import KINDS, cells_of, kind_of
from ..session import Setup
from ..settings import quoted

# Other names of columns, by which people type another unit: name -> column, unit.
OTHER_UNITS = {
    f.sheet[0]: (column, f.sheet[1])
    for kind in KINDS.values()
    for column, f in kind.numbers().items()
    if f.sheet
}
OTHER_UNITS |= {"incline_percent": ("incline_deg", "%"), "drift_km_h": ("drift_m_s", "km/h")}
_NUMBER = re.compile(r"([+-]?(?:\d+(?:[.,]\d*)?|[.,]\d+)(?:[eE][+-]?\d+)?)\s*(\S*)")
_SPELLINGS = {
    "°": "deg",
    "degree": "deg",
    "degrees": "deg",
    "percent": "%",
    "kmh": "km/h",
    "kph": "km/h",
    "km/hr": "km/h",
    "ms": "m/s",
    "mps": "m/s",
    "sec": "s",
    "secs": "s",
    "mins": "min",
    "kgs": "kg",
    "gr": "g",
    "grams": "g",
    "gram": "g",
    "lbs": "lb",
    "inch": "in",
    "inches": "in",
}


@dataclass(frozen=True)
class Typed:
    """A number in the field's unit; question, if not empty, is to be asked before it is taken.

    meant: the value if the question is answered by yes.
    """

    value: float
    question: str = ""
    meant: float | None = None


def parse_number(text: str, field: Field, likely: Range | None = None) -> Typed:
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


def _bare(number: float, field: Field, likely: Range | None) -> Typed:
    """Judge a number without a unit by the range it was expected in."""
    if likely is not None and number and not likely[0] <= number <= likely[1]:
        for unit in list(UNITS[field.quantity])[1:]:
            other = _converted(number, unit, field)
            if likely[0] <= other <= likely[1]:
                return Typed(
                    number,
                    f"{number:g} {field.unit} is outside {span(likely)} {field.unit}; "
                    f"did you mean {number:g} {unit} = {other:.4g} {field.unit}?",
                    other,
                )
    return Typed(_checked(number, field))


def span(likely: Range) -> str:
    """Return a range in words."""
    return f"{likely[0]:.3g} to {likely[1]:.3g}"


def _unit(text: str, field: Field) -> str:
    units = {unit.lower(): unit for unit in UNITS[field.quantity]}
    unit = _SPELLINGS.get(text.lower(), text.lower())
    if unit not in units:
        raise BadInput(f"{text!r} is no unit of this; {_example(field)}")
    return units[unit]


def _converted(number: float, unit: str, field: Field) -> float:
    if field.quantity == "incline" and unit == "%":
        return math.degrees(math.atan(number / 100))
    if field.quantity == "grade" and unit == "deg":
        return 100 * math.tan(math.radians(number))
    return number * UNITS[field.quantity][unit]


def _checked(value: float, field: Field) -> float:
    if not field.low <= value <= field.high or (field.open_low and value == field.low):
        says = field.words if field.words.endswith("shows") else f"{field.words} is"
        raise BadInput(
            f"{value:.4g} {field.unit} cannot be: {says} {field.low:g} to {field.high:g} "
            f"{field.unit}; {_example(field)}"
        )
    return value


def _example(field: Field) -> str:
    if field.quantity == "count":
        return "type a number, such as 6"
    units = " or ".join(UNITS[field.quantity])
    return f"type a number in {units}, such as {_SAMPLES[field.quantity]}"


_SAMPLES = {
    "incline": "2.3 or 4 %",
    "angle": "150",
    "speed": "0.45 or 1.6 km/h",
    "length": "1.2 or 76 mm",
    "rate": "3.14 or 0.5 Hz",
    "time": "9.5",
    "mass": "0.48 or 480 g",
    "grade": "0.5",
    "belt": "0.1",
    "voltage": "5.2",
}


def read_cells(
    kind: str, cells: Iterable[str], setup: Setup, old: Mapping[str, str] | None = None
) -> dict[str, Any]:
    """Return the values of one reading from NAME=VALUE pairs, derived ones too; raises BadInput.

    old: the row that is redone; what is not named stays as it was.
    """
    declared = kind_of(kind)
    fields = {field.column: field for field in declared.fields}
    pairs: list[tuple[str, str]] = []
    for cell in cells:
        name, equals, text = cell.partition("=")
        if not equals or OTHER_UNITS.get(name, (name,))[0] not in fields:
            raise BadInput(f"{cell!r} is not NAME=VALUE with a name of {', '.join(_names(fields))}")
        pairs.append((name, text))
    found: dict[str, Any] = {}
    for name, text in in_columns(pairs).items():
        field = fields[name]
        number = isinstance(field, Field)
        found[name] = parse_number(text, field).value if number else field.read(text)
    if old is not None:
        return redone(kind, old, found, setup)
    return completed(kind, found, setup)


def _names(columns: Iterable[str]) -> list[str]:
    """Return columns, each with the names for it in other units."""
    others = {column: name for name, (column, _) in OTHER_UNITS.items()}
    return [f"{c} (or {others[c]})" if c in others else c for c in columns]


def in_columns(typed: Iterable[tuple[str, Any]]) -> dict[str, Any]:
    """Return what was typed by column; a name of another unit puts this unit behind a bare number.

    Raises BadInput where one column is given twice, by whichever names.
    """
    found: dict[str, tuple[str, Any]] = {}
    for name, value in typed:
        column, unit = OTHER_UNITS.get(name, (name, ""))
        if column in found:
            both = " and ".join(dict.fromkeys((found[column][0], name)))
            raise BadInput(f"{both}: one quantity is given twice; give it once")
        bare = unit and not re.search(r"[^\W\d_]$|%$", str(value).strip())
        found[column] = name, f"{value} {unit}" if bare else value
    return {column: value for column, (_, value) in found.items()}


def listed_cells(kind: str, row: Mapping[str, Any]) -> dict[str, Any]:
    """Return a script's cells by column, numbers of another unit converted; raises BadInput."""
    numbers = kind_of(kind).numbers()
    own = {n: v for n, v in row.items() if OTHER_UNITS.get(n, (n,))[0] in numbers}
    found = {
        c: parse_number(v, numbers[c]).value if c not in row else v
        for c, v in in_columns(own.items()).items()
    }
    return {n: v for n, v in row.items() if n not in own} | found


def completed(kind: str, found: Mapping[str, Any], setup: Setup) -> dict[str, Any]:
    """Return a reading's values with what an empty answer means, and what follows from others."""
    usual = {
        column: field.usual
        for column, field in kind_of(kind).numbers().items()
        if field.usual is not None and not field.optional  # what was not said is not known
    }
    return kind_of(kind).derived(usual | dict(found), setup.stopwatch)


def redone(
    kind: str, old: Mapping[str, str], found: dict[str, Any], setup: Setup
) -> dict[str, Any]:
    """Return a row's values with those read anew; what follows from them follows again."""
    declared = kind_of(kind)
    derived = {c for c, f in declared.numbers().items() if f.source == DERIVED}
    stale = derived if found.keys() - derived and not derived & found.keys() else set()
    there = cells_of(old)
    if "drift_m_s" in found and "places" not in found:
        there.pop("places", None)  # a drift that was typed anew: of these places no more
    anew = declared.derived(
        {k: v for k, v in there.items() if k not in stale} | found, setup.stopwatch
    )
    return {**there, **anew}


def amendment(change: str) -> str:
    """Return TABLE.ENTRY=VALUE as a line of TOML: numbers with units converted, words quoted."""
    name, equals, value = (part.strip() for part in change.partition("="))
    if not equals or "." not in name or not value:
        raise BadInput(f"{change!r} is not TABLE.ENTRY=VALUE, such as robot.mass_kg=480g")
    if name.startswith("laboratory.") or name in ("plan.bend", "plan.on"):
        return f"{name} = {quoted(value.strip(chr(34)))}"
    field = Field(name, name, -1e9, 1e9)
    if field.quantity == "count" or value.startswith(("[", '"', "'")):
        return f"{name} = {value}"
    return f"{name} = {parse_number(value, field).value!r}"
