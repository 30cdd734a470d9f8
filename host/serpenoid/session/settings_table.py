"""A table of session.toml as a dataclass: its fields are the keys, in their units, with limits."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import MISSING, Field, dataclass, field, fields, replace
from typing import Any, TypeVar

from ..base.checks import check_choice, check_number, check_whole
from ..base.errors import BadInput
from ..base.toml_table import Table, located
from ..model.gait import Gait
from .declaration import Field as Number
from .declaration import in_si

T = TypeVar("T", bound="SettingsTable")
_TYPES = {"str": (str, "text in quotes"), "bool": (bool, "true or false")}


def choice(*choices: str, default: Any = MISSING, note: str = "") -> Any:
    """Declare one of some words."""
    return field(default=default, metadata={"choices": choices, "note": note})


def read_by(reader: Callable[[Any], Any], default: Any = MISSING, note: str = "") -> Any:
    """Declare a value that a function checks, and returns as it is held."""
    return field(default=default, metadata={"reader": reader, "note": note})


def in_si_units(key: str) -> Any:
    """Return the property that has a key's number in SI."""
    return property(lambda table: in_si(key, getattr(table, key)))


@dataclass(frozen=True)
class SettingsTable:
    """Hold a table's values, each within its limits; raises BadInput, naming key and limit."""

    def __post_init__(self) -> None:
        for part in fields(self):
            object.__setattr__(self, part.name, _checked(part, getattr(self, part.name)))

    @classmethod
    def read(cls: type[T], table: Table) -> T:
        """Return a file's table; raises BadInput, naming file and line, too."""
        parts = {part.name: part for part in fields(cls)}
        needed = [name for name, part in parts.items() if part.default is MISSING]
        table.only(*needed, optional=tuple(name for name in parts if name not in needed))
        values = dict[str, Any]()
        for name, value in table.values.items():
            with located(table.where(name)):
                values[name] = _checked(parts[name], value)
        with located(table.heading):
            return cls(**values)

    @classmethod
    def limits(cls, key: str) -> Number:
        """Return a key's limits, as a number that a person types."""
        limits: Number = cls.__dataclass_fields__[key].metadata["limits"]
        return replace(limits, column=key)

    def text(self) -> str:
        """Return the table's lines in a new file."""
        lines = list[str]()
        for part in fields(self):
            note = part.metadata.get("note", "")
            value = toml_text(getattr(self, part.name))
            lines.append(f"{part.name} = {value}{'  # ' * bool(note)}{note}\n")
        return "".join(lines)


def _checked(part: Field[Any], value: Any) -> Any:
    """Return a setting's value as it is held; raises BadInput."""
    if str(part.type).endswith("| None") and value in (None, ""):
        return None
    if "reader" in part.metadata:
        return part.metadata["reader"](value)
    if "choices" in part.metadata:
        return check_choice(part.name, value, part.metadata["choices"])
    if "limits" in part.metadata:
        return _number(part.name, str(part.type), value, part.metadata["limits"])
    kind, words = _TYPES[str(part.type)]
    if not isinstance(value, kind) or value == "":
        raise BadInput(f"{part.name} is {value!r}; it must be {words}")
    return value


def _number(name: str, kind: str, value: Any, limits: Number) -> Any:
    """Return a number within limits, whole or not, or a tuple of them; raises BadInput."""
    low, high, open_low = limits.low, limits.high, limits.open_low
    if kind == "int":
        return check_whole(name, value, int(low), int(high))
    if not kind.startswith("tuple"):
        return check_number(name, value, low, high, open_low=open_low)
    if not isinstance(value, (list, tuple)) or not value:
        raise BadInput(f"{name} is {value!r}; it must be a list of numbers")
    return tuple(check_number(name, one, low, high, open_low=open_low) for one in value)


def toml_text(value: Any) -> str:
    """Return a value as TOML has it; None is an empty text, which a person fills in."""
    text = str(value)
    match value:
        case None:
            text = '""'
        case bool():
            text = str(value).lower()
        case str():
            text = json.dumps("".join(c for c in value if c != "\x7f"), ensure_ascii=False)
        case float():
            text = f"{value:.10g}"
            text += ".0" * text.lstrip("-").isdecimal()
        case Gait():
            alpha, beta = (f"{math.degrees(x):.10g}" for x in (value.alpha_rad, value.beta_rad))
            rate = f"{value.omega_rad_s:.10g}"
            text = f"\n  {{ alpha_deg = {alpha}, beta_deg = {beta}, omega_rad_s = {rate} }},"
        case tuple():
            parts = [toml_text(part) for part in value]
            lines = "".join(parts)
            text = f"[{lines}\n]" if "\n" in lines else f"[{', '.join(parts)}]"
    return text
