"""Numbers and words as dataclasses declare them: settings of a session, columns of a reading."""

from __future__ import annotations

import json
import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import MISSING, dataclass, field, fields, replace
from typing import Any, ClassVar, TypeVar

from ..base.checks import check_choice, check_number, check_text, check_whole
from ..base.errors import BadInput
from ..base.toml_table import Table, located
from ..model.gait import Gait

T = TypeVar("T", bound="SettingsTable")
Cells = Mapping[str, str | float]
Values = dict[str, float | str]
Range = tuple[float, float]  # Ends of the range in which a number is expected.
Units = dict[str, float]
LENGTH_UNITS: Units = {
    "m": 1.0,
    "cm": 0.01,
    "mm": 0.001,
    "in": 0.0254,
    "ft": 0.3048,
    "yd": 0.9144,
}
# By the ends of columns' names, the first that fits: the units that a person may type a number in,
# unit -> factor to the first, and an example. A grade is converted by its arctangent.
QUANTITIES: dict[str, tuple[Units, str]] = {
    "incline_deg": ({"deg": 1.0, "%": 0.0}, "2.3 or 4 %"),
    "reversed_deg": ({"deg": 1.0, "%": 0.0}, "2.3 or 4 %"),
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


def in_si(name: str, value: float) -> float:
    """Return a value in SI that is given in the unit of its name."""
    if name.endswith("_deg"):
        return math.radians(value)
    per_si = {"percent": 100.0, "ms": 1e3, "mm": 1e3, "h": 3.6}
    return value / per_si.get(name.rpartition("_")[2], 1.0)


@dataclass(frozen=True)
class Field:
    """One number, word or text of a table or of a reading.

    column: its key or column, unit included. kind: type of the attribute, such as `float | None`;
    by it the field may be empty, is an integer or is several. words: what it is, as a person is
    asked for it. low, high: limits, low itself excluded
    if open_low. likely: the range that is expected, or None; why: what it means to be beyond it.
    usual: what an empty answer means, or None. note: what stands behind it in a new session.toml.

    Of words: choices, of which it is one, if there are any; blank: it may be empty; tidy: returns
    what is given as it is kept, raises BadInput.
    """

    column: str = ""
    kind: str = "float"
    words: str = ""
    low: float = 0.0
    high: float = math.inf
    likely: Range | None = None
    why: str = ""
    usual: float | None = None
    open_low: bool = False
    note: str = ""
    choices: tuple[str, ...] = ()
    blank: bool = True
    tidy: Callable[[Any], Any] | None = None

    @property
    def is_number(self) -> bool:
        """Tell whether it is a number, or several."""
        return self.tidy is None and "str" not in self.kind

    @property
    def optional(self) -> bool:
        """Tell whether it may be empty."""
        return self.kind.endswith("None")

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

    def unitless(self, value: Any) -> Any:
        """Return the number of a text such as "480 g" in the column's unit, others as they are."""
        if self.is_number and isinstance(value, str):
            number, _, unit = value.partition(" ")
            factor = self.units.get(unit)
            with suppress(ValueError):
                return float(number) * factor if factor else value
        return value

    def check(self, value: Any) -> Any:
        """Return a value as it is kept, None if it is empty and may be; raises BadInput."""
        if self.tidy:
            return self.tidy(value)
        if not self.is_number:
            name, words = self.column, self.choices
            return (
                check_choice(name, value, words) if words else check_text(name, value, self.blank)
            )
        if self.optional and value in (None, ""):
            return None
        if self.kind == "int":
            return check_whole(self.column, value, int(self.low), int(self.high))
        if not self.kind.startswith("tuple"):
            return check_number(self.column, value, self.low, self.high, open_low=self.open_low)
        if not isinstance(value, (list, tuple)) or not value:
            raise BadInput(f"{self.column} is {value!r}; it must be a list of numbers")
        return tuple(map(replace(self, kind="float").check, value))

    def read(self, text: str) -> Any:
        """Return a cell's word, or its number in SI; raises BadInput."""
        if not self.is_number:
            return self.check(text or next(iter(self.choices), ""))
        try:
            value: object = float(text)
        except ValueError:  # check says what is there instead of a number
            value = text
        number = self.check(value)
        return None if number is None else in_si(self.column, number)


def number_field(
    low: float = 0.0,
    high: float = math.inf,
    *,
    default: Any = MISSING,
    shown: bool = True,
    **more: Any,
) -> Any:
    """Declare a number, or a tuple of them; one whose type has None may stay empty.

    more: as of a Field. shown: it is part of a session's hash.
    """
    limits = Field(low=low, high=high, **more)
    return field(default=default, repr=shown, metadata={"limits": limits})


def word_field(*choices: str, default: Any = None, **more: Any) -> Any:
    """Declare a word or text, by default the first choice or none. more: as of a Field."""
    usual = next(iter(choices), "") if default is None else default
    return field(default=usual, metadata={"limits": Field(choices=choices, **more)})


class Declared:
    """A dataclass whose fields are keys or columns of a file.

    declared: attribute -> its Field, whose column, if it states none, is the attribute's name, but
    lambda_deg of lambda_rad.
    """

    declared: ClassVar[dict[str, Field]] = {}

    def __init_subclass__(cls) -> None:
        cls.declared = dict(cls.declared)  # fields of the class above
        for name, value in vars(cls).items():
            if "limits" in getattr(value, "metadata", {}):
                limits, kind = value.metadata["limits"], cls.__annotations__[name]
                column = name.removesuffix("_rad") + "_deg" * name.endswith("_rad")
                column = limits.column or column
                cls.declared[name] = replace(limits, column=column, kind=kind)


@dataclass(frozen=True, kw_only=True)
class Observation(Declared, ABC):
    """A reading; each kind is a dataclass of this whose declared fields are its columns, in SI.

    number: from 1, unique in a session. voided: not to be used, for the reason in comment.

    kind: what readings.csv calls it. fitted: the friction fit rests on it, so that the session's
    hash covers it. columns: of its file of samples (`tracks`), which the attribute `track` holds;
    none if it has no file. track_may_miss: some readings have none.
    """

    kind: ClassVar[str]
    fitted: ClassVar[bool] = False
    columns: ClassVar[tuple[str, ...]] = ()
    track_may_miss: ClassVar[bool] = False

    number: int = 0
    voided: bool = False
    comment: str = field(default="", repr=False)

    @classmethod
    def questions(cls, *columns: str) -> tuple[Field, ...]:
        """Return the numbers of some columns, of all unless given."""
        numbers = {f.column: f for f in cls.declared.values() if f.is_number}
        return tuple(numbers[column] for column in columns or numbers)

    @classmethod
    def derived(cls, cells: dict[str, Any], watch: Any) -> dict[str, Any]:
        """Put in what follows from other cells, by the Instruments; raises BadInput.

        Also where what is typed cannot be, although each number is within its limits.
        """
        return cells

    @abstractmethod
    def in_words(self) -> tuple[str, str]:
        """Return (title, values) for tables, e.g. ('station, bend 15°', '2.6°, belt 0.170')."""


def in_si_units(key: str) -> Any:
    """Return the property that has a key's number in SI."""
    return property(lambda table: in_si(key, getattr(table, key)))


@dataclass(frozen=True)
class SettingsTable(Declared):
    """A table of session.toml, its values within their limits, each in its key's unit.

    Raises BadInput, naming key and limit.
    """

    def __post_init__(self) -> None:
        for name, limits in self.declared.items():
            object.__setattr__(self, name, limits.check(getattr(self, name)))

    @classmethod
    def read(cls: type[T], table: Table) -> T:
        """Return a file's table; raises BadInput, naming file and line, too."""
        needed = [part.name for part in fields(cls) if part.default is MISSING]
        table.check_keys(
            *needed, optional=tuple(name for name in cls.declared if name not in needed)
        )
        values = dict(table.values)
        for name, value in values.items():
            with located(table.where(name)):
                limits = cls.declared[name]
                values[name] = limits.check(limits.unitless(value))
        with located(table.heading):
            return cls(**values)

    def file_value(self, name: str) -> Any:
        """Return the value of a key as a new file has it."""
        return getattr(self, name)

    def text(self) -> str:
        """Return the table's lines in a new file."""
        lines = list[str]()
        for name, limits in self.declared.items():
            note = f"  # {limits.note}" if limits.note else ""
            lines.append(f"{name} = {toml_text(self.file_value(name))}{note}\n")
        return "".join(lines)


def toml_text(value: Any) -> str:
    """Return a value as TOML has it; None is an empty text, which a person fills in."""
    if isinstance(value, Gait):
        alpha, beta = (f"{math.degrees(x):.10g}" for x in (value.alpha_rad, value.beta_rad))
        rate = f"{value.omega_rad_s:.10g}"
        return f"\n  {{ alpha_deg = {alpha}, beta_deg = {beta}, omega_rad_s = {rate} }}"
    if isinstance(value, tuple):
        return f"[{', '.join(map(toml_text, value))}]".replace(", \n", ",\n")
    if isinstance(value, float):
        value = float(f"{value:.10g}")
    return json.dumps("" if value is None else value, ensure_ascii=False).replace("\x7f", "")
