"""Readings on a command line: NAME=VALUE, the value with a unit or in the column's own."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from ....model.checks import check_choice
from ....model.errors import BadInput
from ...session import FACINGS, Setup
from ...session_rows import facing_of
from ..new_session import quoted
from ..steps import Field
from .typed import read_typed

_INCLINE = (-45.0, 45.0)
FIELDS: dict[str, tuple[Field, ...]] = {
    "station": (
        Field("lambda_deg", "the bend", "angle", 0.0, 60.0),
        Field("incline_deg", "the incline", "incline", 0.05, 45.0),
        Field("belt_speed_m_s", "the belt's speed", "speed", 0.0, 10.0),
        Field("drift_m_s", "the drift", "speed", -10.0, 10.0, usual=0.0),
    ),
    "zero": (
        Field("incline_deg", "the inclinometer", "incline", *_INCLINE),
        Field("reversed_deg", "the inclinometer, turned", "incline", *_INCLINE),
    ),
    "bend": (
        Field("lambda_deg", "the bend", "angle", 0.0, 60.0),
        Field("between_links_deg", "the protractor", "angle", 30.0, 180.0),
    ),
    "gait": (
        Field("alpha_deg", "alpha", "angle", 0.0, 180.0),
        Field("beta_deg", "beta", "angle", -360.0, 360.0),
        Field("omega_rad_s", "omega", "rate", 1e-3, 100.0),
        Field("distance_m", "the distance", "length", 0.0, 1000.0),
        Field("duration_s", "the time", "time", 0.1, 1e5),
        Field("speed_m_s", "the speed", "speed", 0.0, 10.0),
        Field("speed_sigma_m_s", "its standard deviation", "speed", 1e-6, 10.0),
    ),
}


def read_cells(
    kind: str, cells: Iterable[str], setup: Setup, old: Mapping[str, str] | None = None
) -> dict[str, float | str]:
    """Read NAME=VALUE pairs of one reading; raises BadInput.

    A station may say facing=up (the belt) or down. A gait run's speed follows from distance and
    time unless given. old: the row that is redone.
    """
    fields = {field.column: field for field in FIELDS[kind]}
    found: dict[str, float] = {}
    words: dict[str, str] = {}
    for cell in cells:
        name, equals, text = cell.partition("=")
        if kind == "station" and name == "facing":
            words[name] = check_choice(name, text, FACINGS)
            continue
        if not equals or name not in fields:
            raise BadInput(f"{cell!r} is not NAME=VALUE with a name of {', '.join(fields)}")
        found[name] = read_typed(text, fields[name]).value
    if kind == "station" and old is None:
        found.setdefault("drift_m_s", 0.0)
    if kind == "gait" and {"distance_m", "duration_s"} & set(found):
        distance_m, duration_s = (
            _either(name, found, old) for name in ("distance_m", "duration_s")
        )
        speed, sigma = setup.stopwatch.speed(distance_m, duration_s)
        found = {"speed_m_s": speed, "speed_sigma_m_s": sigma} | found
    return found | words


_KINDS = {"_m_s": "speed", "_kg": "mass", "_m": "length", "_deg": "angle", "_percent": "grade",
          "_s": "time"}  # fmt: skip


def amendment(change: str) -> str:
    """Return TABLE.ENTRY=VALUE as a line of TOML: numbers with units converted, words quoted."""
    name, equals, value = (part.strip() for part in change.partition("="))
    if not equals or "." not in name or not value:
        raise BadInput(f"{change!r} is not TABLE.ENTRY=VALUE, such as robot.mass_kg=480g")
    if name.startswith("laboratory."):
        return f"{name} = {quoted(value.strip(chr(34)))}"
    kind = next((kind for end, kind in _KINDS.items() if name.endswith(end)), "")
    if not kind or value.startswith(("[", '"', "'")):
        return f"{name} = {value}"
    field = Field(name.partition(".")[2], name, kind, -1e9, 1e9)
    return f"{name} = {read_typed(value, field).value!r}"


def values_of(row: Mapping[str, str]) -> dict[str, float | str]:
    """Return the numbers that a row holds, as they stand, and which way a station faced."""
    found: dict[str, float | str] = {
        f.column: row[f.column] for f in FIELDS[row["kind"]] if row[f.column]
    }
    return found | ({"facing": facing_of(row["more"])} if row["kind"] == "station" else {})


def _either(name: str, found: Mapping[str, float], old: Mapping[str, str] | None) -> float:
    if name in found:
        return found[name]
    if old and old[name]:
        return float(old[name])
    raise BadInput(f"a gait run needs both distance_m and duration_s; {name} is missing")
