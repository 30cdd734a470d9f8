"""A kind of servo as a TOML file: Servo's fields, and what is in doubt about them."""

from __future__ import annotations

import dataclasses
from dataclasses import replace
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
    others = ("name", "source", "sigma", "updates_hz", "drawn", "remark")
    top.only("format", "servo", optional=others)
    table = top.table("servo").without_removed(REMOVED)
    table.only(optional=_FIELDS)
    values: dict[str, Any] = {name: table.number(name) for name in table.values}
    with located(table.heading):
        servo = Servo(**values)
    sigma: dict[str, float] = {}
    if "sigma" in top.values:
        doubt = top.table("sigma")
        doubt.only(optional=UNCERTAIN)
        sigma = {name: doubt.number(name, 0.0, 3.0) for name in doubt.values}
    name = top.string("name") if "name" in top.values else Path(path).stem
    source = top.string("source") if "source" in top.values else str(path)
    updates = top.numbers("updates_hz", 0.0, 1e4) if "updates_hz" in top.values else ()
    drawn = _load_drawn(top, servo) if "drawn" in top.values else ()
    remark = top.string("remark") if "remark" in top.values else ""
    return ServoKind(name, servo, sigma, updates, source, drawn, remark)


def _load_drawn(top: Table, typical: Servo) -> tuple[Servo, ...]:
    """Return the servos of [drawn]: lists of equal length, by field."""
    table = top.table("drawn").without_removed(REMOVED)
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
    if kind.source:
        values["source"] = kind.source
    if kind.remark:
        values["remark"] = kind.remark
    if kind.updates_hz:
        values["updates_hz"] = list(kind.updates_hz)
    values["servo"] = {name: getattr(kind.servo, name) for name in _FIELDS}
    if kind.sigma:
        values["sigma"] = dict(kind.sigma)
    if kind.drawn:
        values["drawn"] = {
            name: [float(f"{getattr(one, name):.6g}") for one in kind.drawn]
            for name in _FIELDS
            if len({getattr(one, name) for one in (*kind.drawn, kind.servo)}) > 1
        }
    write_named(path, tomli_w.dumps(values))
