"""What the declaration of a kind of reading consists of: its fields, and what it is used for."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from ...model.checks import check_choice, check_number
from .instruments import Stopwatch

Cells = Mapping[str, str | float]
Values = dict[str, float | str]
Range = tuple[float, float]  # that a number is expected in
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
# Quantities by the ends of columns' names, the first that fits; others are counts.
QUANTITIES = {
    "incline_deg": "incline",
    "reversed_deg": "incline",
    "_deg": "angle",
    "_percent": "grade",
    "_km_h": "belt",
    "_rad_s": "rate",
    "_m_s": "speed",
    "_m": "length",
    "_kg": "mass",
    "_s": "time",
    "_v": "voltage",
}
READ, PLANNED, DERIVED = "read", "planned", "derived"


@dataclass(frozen=True)
class Field:
    """One number of a reading.

    column: its name in readings.csv, unit included. words: what a person is asked for. low, high:
    limits, low itself excluded if open_low. likely: the range that is expected, or None; why: what
    it means to be beyond it. usual: what an empty answer means, or None. source: READ off by a
    person, PLANNED (the plan or the board tells it) or DERIVED from the others. attribute: of the
    reading, in SI; the column's name with `_rad` for `_deg` unless given. optional: the cell may be
    empty. sheet: column and unit of the sheet to type into, where people use another unit.
    """

    column: str
    words: str
    low: float
    high: float
    likely: Range | None = None
    why: str = ""
    usual: float | None = None
    open_low: bool = False
    source: str = READ
    attribute: str = ""
    optional: bool = False
    sheet: tuple[str, str] | None = None

    @property
    def quantity(self) -> str:
        """Return a key of UNITS; bare numbers are in its first unit, which is the column's."""
        return next((q for end, q in QUANTITIES.items() if self.column.endswith(end)), "count")

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


class Taken:
    """A reading; each kind is a dataclass of this that declares all of its kind.

    kind: what readings.csv calls it. fields: numbers and words, in the order of asking. part: the
    attribute of Session that holds such readings. fitted: the friction fit rests on it, so that the
    session's hash covers it. columns: of its file of samples (`tracks`), which the attribute
    `track` holds; none if it has no file. track_may_miss: some readings have none.

    Its dataclass has number, voided, comment and time_utc besides the fields' attributes. Raises
    BadInput, naming value and limits, where one of them is out of range.
    """

    __slots__ = ()
    kind: ClassVar[str]
    fields: ClassVar[tuple[Field | Word, ...]]
    part: ClassVar[str] = "further"
    fitted: ClassVar[bool] = False
    columns: ClassVar[tuple[str, ...]] = ()
    track_may_miss: ClassVar[bool] = False

    def __post_init__(self) -> None:
        check_number("number", self.number, 1)  # type: ignore[attr-defined]
        for field in self.fields:
            field.check(self)

    @classmethod
    def numbers(cls) -> dict[str, Field]:
        """Return the fields that are numbers, by their columns."""
        return {f.column: f for f in cls.fields if isinstance(f, Field)}

    @classmethod
    def asked(cls, *columns: str) -> tuple[Field, ...]:
        """Return the numbers of some columns, of all unless given."""
        numbers = cls.numbers()
        return tuple(numbers[column] for column in columns or numbers)

    @classmethod
    def derived(cls, cells: dict[str, Any], watch: Stopwatch) -> dict[str, Any]:
        """Put in what follows from other cells, as a speed does; raises BadInput."""
        return cells

    def in_words(self) -> tuple[str, str]:
        """Return what it is, and its values."""
        raise NotImplementedError
