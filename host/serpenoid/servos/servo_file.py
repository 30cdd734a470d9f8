"""A kind of servo as a TOML file: Servo's fields, and what is in doubt about them."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

from ..model.drives import UNCERTAIN, Servo, ServoKind
from ..model.toml_table import Table, located

FORMAT = 1
_FIELDS = tuple(f.name for f in dataclasses.fields(Servo))


def load_servo(path: str | Path) -> ServoKind:
    """Read a kind of servo from a TOML file.

    `format = 1`, `name` and `source` (both may be missing), [servo] with Servo's fields (those that
    are missing have its defaults), and [sigma] with the standard deviation of the logarithm of some
    of them (missing: exact). Raises BadInput.
    """
    top = Table.load(Path(path))
    top.check_format(FORMAT)
    top.only("format", "servo", optional=("name", "source", "sigma", "updates_hz"))
    table = top.table("servo")
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
    return ServoKind(name, servo, sigma, updates, source)


def save_servo(kind: ServoKind, path: str | Path) -> None:
    """Write a kind of servo to a TOML file, which load_servo reads. Raises SerpenoidError."""
    import tomli_w

    from ..simulation.scene_file import write_whole

    values: dict[str, Any] = {"format": FORMAT, "name": kind.name}
    if kind.source:
        values["source"] = kind.source
    if kind.updates_hz:
        values["updates_hz"] = list(kind.updates_hz)
    values["servo"] = {name: getattr(kind.servo, name) for name in _FIELDS}
    if kind.sigma:
        values["sigma"] = dict(kind.sigma)
    write_whole(path, tomli_w.dumps(values))
