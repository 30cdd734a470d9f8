"""What the declaration of a reading kind consists of: its fields, and how they are shown."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ...model.checks import check_choice, check_number
from .instruments import Stopwatch

Cells = Mapping[str, str | float]
# Quantities and the units that a person may type them in: unit -> factor to the first.
UNITS: dict[str, dict[str, float]] = {
    "incline": {"deg": 1.0, "%": 0.0},  # grade: by the arctangent, not by a factor
    "angle": {"deg": 1.0},
    "grade": {"%": 1.0, "deg": 0.0},
    "speed": {"m/s": 1.0, "km/h": 1 / 3.6, "cm/s": 0.01, "mm/s": 0.001, "mph": 0.44704},
    "belt": {"km/h": 1.0, "m/s": 3.6, "mph": 1.609344},  # a treadmill's own steps
    "length": {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254},
    "mass": {"kg": 1.0, "g": 0.001, "lb": 0.45359237},
    "count": {"": 1.0},
    "rate": {"rad/s": 1.0, "Hz": 2 * math.pi},
    "time": {"s": 1.0, "min": 60.0},
    "voltage": {"V": 1.0},
}
READ, PLANNED, DERIVED = "read", "planned", "derived"


@dataclass(frozen=True)
class Field:
    """One number of a reading.

    column: its name in readings.csv, unit included. words: what a person is asked for. quantity: a
    key of UNITS; bare numbers are in its first unit, which is the column's. low, high: limits, low
    itself excluded if open_low. likely: the range that is expected, or None; why: what it means to
    be beyond it. usual: what an empty answer means, or None. source: READ off by a person, PLANNED
    (the plan or the board tells it) or DERIVED from the others. attribute: of the reading, in SI;
    the column's name with `_rad` for `_deg` unless given. optional: the cell may be empty. sheet:
    column and unit of the sheet to type into, where people use another unit.
    """

    column: str
    words: str
    quantity: str
    low: float
    high: float
    likely: tuple[float, float] | None = None
    why: str = ""
    usual: float | None = None
    open_low: bool = False
    source: str = READ
    attribute: str = ""
    optional: bool = False
    sheet: tuple[str, str] | None = None

    @property
    def unit(self) -> str:
        """Return the unit of a bare number, that of the column."""
        return next(iter(UNITS[self.quantity]))

    @property
    def name(self) -> str:
        """Return the name of the reading's attribute."""
        return self.attribute or self.column.replace("_deg", "_rad")

    def si(self, value: float) -> float:
        """Return a value of the column in SI."""
        return math.radians(value) if self.column.endswith("_deg") else value

    def read(self, text: str) -> float | None:
        """Return a cell's number in SI, None if it is empty and may be; raises BadInput."""
        if not text and self.optional:
            return None
        try:
            value: object = float(text)
        except ValueError:  # check_number says what is there instead of a number
            value = text
        return self.si(
            check_number(self.column, value, self.low, self.high, open_low=self.open_low)
        )

    def check(self, reading: object) -> None:
        """Raise BadInput if a reading's value is beyond the limits."""
        value = getattr(reading, self.name)
        if value is None and self.optional:
            return
        low, high = self.si(self.low), self.si(self.high)
        check_number(self.name, value, low, high, open_low=self.open_low)


@dataclass(frozen=True)
class Word:
    """One word of a reading: one of the choices, the first where nothing is said.

    choices: none if any word without a space will do. of_plan: what is not said when it is typed is
    as the plan's attribute of this name has it. source: as of a Field. tidy: returns what is typed
    as it is kept, without a blank; raises BadInput.
    """

    column: str
    choices: tuple[str, ...] = ()
    of_plan: bool = False
    source: str = PLANNED
    tidy: Callable[[str], str] | None = None

    @property
    def name(self) -> str:
        """Return the name of the reading's attribute."""
        return self.column

    @property
    def usual(self) -> str:
        """Return what an empty cell means."""
        return self.choices[0] if self.choices else ""

    def read(self, text: str) -> str:
        """Return the word of a cell; raises BadInput."""
        word = self.tidy(text) if self.tidy and text else text or self.usual
        return check_choice(self.column, word, self.choices) if self.choices else word

    def check(self, reading: object) -> None:
        """Raise BadInput if a reading's word is none of the choices."""
        if self.choices:
            check_choice(self.column, getattr(reading, self.name), self.choices)
        if self.tidy and getattr(reading, self.name):
            self.tidy(getattr(reading, self.name))


@dataclass(frozen=True)
class Kind:
    """A kind of reading.

    name: what readings.csv calls it. reading: its dataclass, which has number, voided, comment and
    time_utc besides the fields' attributes. fields: numbers and words, in the order of asking.
    part: the attribute of Session that holds these readings; "" for `Session.further`. describe:
    returns what a reading is and its values, in words. derive: puts in what follows from other
    cells (a speed from distance and time); raises BadInput. fitted: the friction fit rests on it,
    so that the session's hash covers it. track: columns of its file of samples (`tracks`), which
    the attribute `track` holds; none if it has no file. track_may_miss: some readings have none.
    """

    name: str
    reading: type
    fields: tuple[Field | Word, ...]
    describe: Callable[[Any], tuple[str, str]]
    part: str = ""
    derive: Callable[[dict[str, Any], Stopwatch], dict[str, Any]] = lambda cells, watch: cells
    fitted: bool = False
    track: tuple[str, ...] = ()
    track_may_miss: bool = False

    @property
    def numbers(self) -> tuple[Field, ...]:
        """Return the fields that are numbers."""
        return tuple(f for f in self.fields if isinstance(f, Field))

    @property
    def words(self) -> tuple[Word, ...]:
        """Return the fields that are words."""
        return tuple(f for f in self.fields if isinstance(f, Word))

    def __getitem__(self, column: str) -> Field:
        """Return the number of a column."""
        return next(f for f in self.numbers if f.column == column)


def check_fields(reading: object, fields: Sequence[Field | Word]) -> None:
    """Raise BadInput, naming value and limits, if one of a reading's fields is out of range."""
    check_number("number", reading.number, 1)  # type: ignore[attr-defined]
    for field in fields:
        field.check(reading)
