"""A kind of servo as a TOML file: Servo's fields, and what is in doubt about them."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from ..base.errors import BadInput
from ..base.files import write_named
from ..base.toml_table import Table, located
from ..model.drives import REMOVED, UNCERTAIN, Servo, ServoKind

FORMAT = 1
_FIELDS = tuple(f.name for f in dataclasses.fields(Servo))


def load_servo(path: str | Path) -> ServoKind:
    """Read a kind of servo from a TOML file.

    The file has `format = 1` and may have `name`, `source` and a `remark` that warns of it. [servo]
    has Servo's fields; those that are missing have its defaults. [sigma] has standard deviations of
    the logarithm of some of them; the others are exact. [drawn] holds servos that a measurement
    leaves possible: a list for each field that differs.

    Parameters
    ----------
    path
        The file.

    Returns
    -------
    ServoKind
        The kind of servo.

    Raises
    ------
    BadInput
        The message names the file and what is wrong with it.

    Examples
    --------
    >>> sn.save_servo(sn.servo("MG996R"), "servo.toml")
    >>> sn.load_servo("servo.toml").name
    'MG996R'
    """
    top = Table.load(Path(path))
    top.check_format(FORMAT)
    readers: dict[str, Callable[[str], Any]] = {
        "name": top.string,
        "source": top.string,
        "remark": top.string,
        "updates_hz": lambda key: top.numbers(key, 0.0, 1e4),
        "sigma": lambda key: _numbers(top.table(key), UNCERTAIN, 0.0, 3.0),
        "drawn": lambda key: _drawn(top.table(key).without_removed(REMOVED), servo),
    }
    top.only("format", "servo", optional=tuple(readers))
    table = top.table("servo").without_removed(REMOVED)
    with located(table.heading):
        servo = Servo(**_numbers(table, _FIELDS))
    values: dict[str, Any] = {"name": Path(path).stem, "source": str(path)}
    values |= {key: read(key) for key, read in readers.items() if key in top.values}
    return ServoKind(servo=servo, **values)


def _numbers(table: Table, names: tuple[str, ...], *limits: float) -> dict[str, float]:
    """Return the numbers of a table that has some of these names."""
    table.only(optional=names)
    return {name: table.number(name, *limits) for name in table.values}


def _drawn(table: Table, typical: Servo) -> tuple[Servo, ...]:
    """Return the servos of [drawn]: lists of equal length, by field."""
    table.only(optional=_FIELDS)
    columns = {name: table.numbers(name) for name in table.values}
    counts = {len(values) for values in columns.values()}
    if len(counts) != 1:
        raise BadInput(f"{table.heading}: lists of {sorted(counts)} numbers; all must be as long")
    with located(table.heading):
        rows = zip(*columns.values(), strict=True)
        return tuple(replace(typical, **dict(zip(columns, row, strict=True))) for row in rows)


def save_servo(kind: ServoKind, path: str | Path) -> None:
    """Write a kind of servo to a TOML file, which load_servo reads.

    Parameters
    ----------
    kind
        The kind of servo.
    path
        The file.

    Raises
    ------
    SerpenoidError
        If the file cannot be written.

    Examples
    --------
    >>> sn.save_servo(sn.servo("MG996R"), "servo.toml")
    >>> sn.load_servo("servo.toml").name
    'MG996R'
    """
    import tomli_w

    values: dict[str, Any] = {"format": FORMAT, "name": kind.name}
    for key in ("source", "remark", "updates_hz"):
        if getattr(kind, key):
            values[key] = getattr(kind, key)
    values["servo"] = asdict(kind.servo)
    if kind.sigma:
        values["sigma"] = dict(kind.sigma)
    if kind.drawn:
        values["drawn"] = {
            name: [float(f"{getattr(servo, name):.6g}") for servo in kind.drawn]
            for name in _FIELDS
            if len({getattr(servo, name) for servo in (*kind.drawn, kind.servo)}) > 1
        }
    write_named(path, tomli_w.dumps(values))
