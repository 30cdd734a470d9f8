"""Numbers and words as dataclasses declare them: settings of a session, columns of a reading."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import MISSING, dataclass, field, replace
from typing import Any, ClassVar

from ..base.checks import check_choice, check_number

Cells = Mapping[str, str | float]
Values = dict[str, float | str]
Range = tuple[float, float]  # that a number is expected in
Units = dict[str, float]
LENGTH_UNITS: Units = {
    "m": 1.0,
    "cm": 0.01,
    "mm": 0.001,
    "in": 0.0254,
    "ft": 0.3048,
    "yd": 0.9144,
}
BELT_UNITS = ("m/s", "km/h", "mph")  # that treadmills show
_INCLINE: tuple[Units, str] = {"deg": 1.0, "%": 0.0}, "2.3 or 4 %"  # grade: by the arctangent
# By the ends of columns' names, the first that fits: the units that a person may type a number in,
# unit -> factor to the first, and an example.
QUANTITIES: dict[str, tuple[Units, str]] = {
    "incline_deg": _INCLINE,
    "reversed_deg": _INCLINE,
    "_deg": ({"deg": 1.0}, "150"),
    "_percent": ({"%": 1.0, "deg": 0.0}, "0.5"),
    "_km_h": ({"km/h": 1.0, "m/s": 3.6, "mph": 1.609344}, "0.1"),
    "_rad_s": ({"rad/s": 1.0, "Hz": 2 * math.pi}, "3.14 or 0.5 Hz"),
    "_m_s": (
        {"m/s": 1.0, "km/h": 1 / 3.6, "cm/s": 0.01, "mm/s": 0.001, "mph": 0.44704},
        "0.45 or 1.6 km/h",
    ),
    "_m": (LENGTH_UNITS, "1.2 or 76 mm"),
    "_kg": ({"kg": 1.0, "g": 0.001, "lb": 0.45359237}, "0.48 or 480 g"),
    "_s": ({"s": 1.0, "min": 60.0}, "9.5"),
    "_v": ({"V": 1.0}, "5.2"),
    "": ({"": 1.0}, "6"),
}
PER_SI = {"percent": 100.0, "ms": 1e3, "mm": 1e3, "h": 3.6}  # of units that names end in
READ, PLANNED, DERIVED = "read", "planned", "derived"


def in_si(name: str, value: float) -> float:
    """Return a value in SI that is given in the unit of its name."""
    if name.endswith("_deg"):
        return math.radians(value)
    if name.endswith("_sigma_percent"):
        return value * 0.01  # to the last bit: the hash of a session has it
    return value / PER_SI.get(name.rpartition("_")[2], 1.0)


def in_unit(name: str, value: float) -> float:
    """Return a value in the unit of its name that is given in SI."""
    if name.endswith("_deg"):
        return math.degrees(value)
    return value * PER_SI.get(name.rpartition("_")[2], 1.0)


@dataclass(frozen=True)
class Field:
    """One number of a table or of a reading.

    column: its key or column, unit included. words: what a person is asked for. low, high: limits,
    low itself excluded if open_low. likely: the range that is expected, or None; why: what it means
    to be beyond it. usual: what an empty answer means, or None. source: READ off by a person,
    PLANNED (the plan or the board tells it) or DERIVED from the others. optional: it may be empty.
    """

    column: str
    words: str = ""
    low: float = 0.0
    high: float = math.inf
    likely: Range | None = None
    why: str = ""
    usual: float | None = None
    open_low: bool = False
    source: str = READ
    optional: bool = False

    @property
    def units(self) -> Units:
        """Return the units that it may be typed in, unit -> factor to the first."""
        return self._quantity[0]

    @property
    def unit(self) -> str:
        """Return the unit of a bare number, that of the column."""
        return next(iter(self.units))

    @property
    def example(self) -> str:
        """Return in words what may be typed."""
        units = " or ".join(self.units)
        return f"type a number{' in ' * bool(units)}{units}, such as {self._quantity[1]}"

    @property
    def _quantity(self) -> tuple[Units, str]:
        return next(q for end, q in QUANTITIES.items() if self.column.endswith(end))

    def read(self, text: str) -> float | None:
        """Return a cell's number in SI, None if it is empty and may be; raises BadInput."""
        if not text and self.optional:
            return None
        try:
            value: object = float(text)
        except ValueError:  # check_number says what is there instead of a number
            value = text
        number = check_number(self.column, value, self.low, self.high, open_low=self.open_low)
        return in_si(self.column, number)


@dataclass(frozen=True)
class Word:
    """One word of a reading: one of the choices, the first where nothing is said.

    choices: none if any word without a space will do. of_plan: what is not said when it is typed is
    as the plan's attribute of this name has it. tidy: returns what is typed as it is kept, without
    a blank; raises BadInput.
    """

    column: str = ""
    choices: tuple[str, ...] = ()
    of_plan: bool = False
    tidy: Callable[[str], str] | None = None

    @property
    def usual(self) -> str:
        """Return what an empty cell means."""
        return self.choices[0] if self.choices else ""

    def read(self, text: str) -> str:
        """Return the word of a cell; raises BadInput."""
        word = self.tidy(text) if self.tidy and text else text or self.usual
        return check_choice(self.column, word, self.choices) if self.choices else word


def number_field(
    low: float = 0.0,
    high: float = math.inf,
    *,
    default: Any = MISSING,
    note: str = "",
    shown: bool = True,
    **more: Any,
) -> Any:
    """Declare a number, or a tuple of them; one whose type has None may stay empty.

    more: as of a Field. note: what stands behind it in a new session.toml. shown: it is part of a
    session's hash.
    """
    limits = Field("", low=low, high=high, **more)
    return field(default=default, repr=shown, metadata={"limits": limits, "note": note})


def word_field(
    *choices: str, of_plan: bool = False, tidy: Callable[[str], str] | None = None
) -> Any:
    """Declare a word of a reading."""
    limits = Word("", choices, of_plan, tidy)
    return field(default=limits.usual, metadata={"limits": limits})


@dataclass(frozen=True)
class Taken(ABC):
    """A reading; each kind is a dataclass of this whose declared fields are its columns, in SI.

    kind: what readings.csv calls it. part: the attribute of Session that holds such readings.
    fitted: the friction fit rests on it, so that the session's hash covers it. columns: of its file
    of samples (`tracks`), which the attribute `track` holds; none if it has no file.
    track_may_miss: some readings have none. attributes: field -> attribute, lambda_deg in
    lambda_rad. Raises BadInput, naming value and limits, where one of them is out of range.
    """

    kind: ClassVar[str]
    part: ClassVar[str] = "further"
    fitted: ClassVar[bool] = False
    columns: ClassVar[tuple[str, ...]] = ()
    track_may_miss: ClassVar[bool] = False
    fields: ClassVar[tuple[Field | Word, ...]] = ()
    attributes: ClassVar[dict[str, str]] = {}

    def __init_subclass__(cls) -> None:
        found = dict[str, Field | Word]()
        for name, declared in list(vars(cls).items()):
            limits = getattr(declared, "metadata", {}).get("limits")
            if isinstance(limits, Field):
                may_miss = cls.__annotations__[name].endswith("None")
                limits = replace(
                    limits,
                    column=name.removesuffix("_rad") + "_deg" * name.endswith("_rad"),
                    optional=may_miss,
                )
            elif isinstance(limits, Word):
                limits = replace(limits, column=name)
            if limits is not None:
                found[name] = limits
        cls.fields = tuple(found.values())
        cls.attributes = {limits.column: name for name, limits in found.items()}

    def __post_init__(self) -> None:
        for limits in self.fields:
            value, column = getattr(self, self.attributes[limits.column]), limits.column
            if isinstance(limits, Word):
                if limits.choices:
                    check_choice(column, value, limits.choices)
            elif value is not None or not limits.optional:
                low, high = in_si(column, limits.low), in_si(column, limits.high)
                name = self.attributes[column]
                check_number(name, value, low, high, open_low=limits.open_low)

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
    def derived(cls, cells: dict[str, Any], watch: Any) -> dict[str, Any]:
        """Put in what follows from other cells, by the Instruments; raises BadInput."""
        return cells

    def doubt(self) -> str:
        """Return why it is not taken although each number is within its limits; "" if it is."""
        return ""

    @abstractmethod
    def in_words(self) -> tuple[str, str]:
        """Return what it is, and its values."""
