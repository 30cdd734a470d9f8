"""`serpenoid servo`: a servo's file from a bench test of one joint."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING

import click

import serpenoid as sn

from ...show.screen import working
from ..declare import EXISTING, number, option, out_file
from ..options import AS_JSON, plug_options, show_json, take_servo

if TYPE_CHECKING:
    from ...servos.bench_test import BenchTest, MeasuredServo

_COLUMNS = ("t_s", "setpoint_deg", "angle_deg")


@click.command()
@option(
    "--test",
    "table",
    "Bench test of one joint: columns t_s, setpoint_deg, angle_deg.",
    required=True,
    type=EXISTING,
    metavar="CSV",
)
@option("--like", "What is known before.", default="hobby", metavar="NAME|FILE")
@plug_options
@number("--sigma-deg", "Standard deviation of the angles of --test.", default=0.5)
@number(
    "--inertia-kg-m2",
    "Inertia of what the joint of --test turns, about it.",
    default=0.0,
    show_default=True,
)
@option("--out", "File for --servo of other commands.", type=out_file(".toml"))
@AS_JSON
def servo(
    table: Path,
    like: str,
    sigma_deg: float,
    inertia_kg_m2: float,
    out: Path | None,
    as_json: bool,
) -> None:
    """Measure a servo: which ones of a kind would have moved so.

    A bench test tells speed, loop, rotor and gear, all but the rotor and the torque themselves:
    only their ratio, unless the joint turns a known inertia as large as the rotor's.
    """
    from ...model.checks import check_number
    from ...servos.bench_test import servo_of_test

    name = "measured" if out is None else out.stem
    kind = take_servo(like)
    if kind is None:
        raise click.UsageError(
            "--like ideal has no servo to measure; give hobby, or a sheet's name"
        )
    check_number("--sigma-deg", sigma_deg, 0.0, 57.0, open_low=True)
    test = read_test(table, math.radians(sigma_deg), inertia_kg_m2)
    with working("trying servos"):
        measured = servo_of_test(test, kind, name=name)
    if out is not None:
        sn.save_servo(measured.kind, out)
    show_json(measured.to_dict()) if as_json else show(measured, out)


def read_test(path: Path, sigma_rad: float, inertia_kg_m2: float) -> BenchTest:
    """Read a bench test's table. Raises BadInput."""
    import numpy as np

    from ...base.files import csv_rows, read_text
    from ...model.checks import check_number
    from ...model.toml_table import located
    from ...servos.bench_test import BenchTest

    rows = csv_rows(read_text(path), path)
    heading = [cell.strip() for cell in rows[0]] if rows else []
    if missing := [name for name in _COLUMNS if name not in heading]:
        raise sn.BadInput(
            f"{path}:1: no column {', '.join(missing)}; needed are {', '.join(_COLUMNS)}"
        )
    columns: list[list[float]] = [[] for _ in _COLUMNS]
    for line, row in enumerate(rows[1:], 2):
        if not any(cell.strip() for cell in row):
            continue
        for column, name in zip(columns, _COLUMNS, strict=True):
            try:
                column.append(check_number(name, float(row[heading.index(name)])))
            except (ValueError, IndexError) as error:
                raise sn.BadInput(f"{path}:{line}: {name} is no finite number") from error
    t, sent, seen = np.array(columns)
    with located(str(path)):
        return BenchTest(t, np.radians(sent), np.radians(seen), sigma_rad, inertia_kg_m2)


def show(measured: MeasuredServo, out: Path | None) -> None:
    """Print how fast the servo is, what was measured of it, and what was not."""
    from ...model.rows import Row, ranged, two_digits
    from ...show import report

    free = measured.shown["no_load_rad_s"]
    report.console.print(
        "Without load the servo turns at about "
        f"{ranged(free.value, 'rad/s', free.low, free.high)}: "
        f"{two_digits(math.pi / 3 / free.value)} s for 60°."
    )
    rows = [
        [*Row(name, "", *one[:3]).cells, f"{100 * one.before:.0f} %", f"{100 * one.after:.1f} %"]
        for name, one in measured.shown.items()
        if one.told
    ]
    report.table(
        measured.kind.source, ["measured", "typical", "95 %", "sigma before", "after"], rows
    )
    lines = [f"chi2 {measured.chi2:.1f} of {measured.readings} readings."]
    if measured.untold:
        lines.append("It does not tell " + ", ".join(measured.untold) + ".")
    if out is not None:
        lines.append(f"Written: {out}; give it to other commands with --servo {out}.")
    for line in lines:
        report.console.print(line)
