"""`serpenoid servo`: a servo's file from a bench test of one joint."""

from __future__ import annotations

import math
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import serpenoid as sn

from ...base.checks import Limits, check_choice
from ...show.screen import say
from ..declare import (
    EXISTING,
    OutFile,
    Setting,
    Values,
    command,
    flag,
    number,
    option,
    settings,
)
from ..options import PLUG, busy, servo_kind, show_json

if TYPE_CHECKING:
    from ...servos.bench_fit import MeasuredServo
    from ...servos.bench_test import BenchTest

COLUMNS = ("t_s", "setpoint_deg", "angle_deg")
SENT = "sent_s"  # a column that a table may have, too
BENCH = (
    Setting(
        "sigma_deg",
        "standard deviation of the angles",
        "deg",
        Limits(0, 57, open_low=True),
        "the table's own scatter",
    ),
    Setting(
        "axis",
        "axis of the load: level (it hangs), or upright",
        usual="level",
        read=lambda name, text: check_choice(name, text, ("level", "upright")),
    ),
    Setting(
        "down_deg", "angle in the table at which the load hangs straight down", "deg", usual="0"
    ),
)


@command()
@option(
    "--test",
    "table",
    "Bench test of one joint: columns t_s, setpoint_deg, angle_deg; sent_s if known.",
    required=True,
    type=EXISTING,
    metavar="CSV",
)
@option("--like", "What is known before.", default="hobby", metavar="NAME|FILE")
@number(
    "--load",
    "What the joint turns: mass, and distance of its centre from the axis.",
    nargs=2,
    metavar="KG M",
)
@flag("--anyway", "Write the file of a test that the model does not describe, with a remark.")
@option("--out", "path", "File for --servo of other commands.", type=OutFile(".toml"))
@settings(*PLUG, *BENCH)
def servo(
    table: Path,
    like: str,
    load: tuple[float, float] | None,
    anyway: bool,
    path: Path | None,
    settings: Values,
    as_json: bool,
) -> None:
    """Measure a servo: whether the model describes a bench test, and which servos would move so.

    A joint without load shows speed, loop, rotor and gear, the last three relative to the torque. A
    load that hangs shows the torque.
    """
    import numpy as np

    from ...base.tables import number_columns
    from ...base.toml_table import located
    from ...servos.bench_fit import servo_of_test
    from ...servos.bench_test import BenchTest, Load

    kind = servo_kind(like, settings)
    sigma_deg, level = settings.get("sigma_deg"), settings.get("axis") != "upright"
    t, setpoint, angle, *sent = number_columns(table, COLUMNS, (SENT,)).values()
    with located(str(table)):
        test = BenchTest(
            np.array(t),
            np.radians(setpoint),
            np.radians(angle),
            None if sigma_deg is None else math.radians(sigma_deg),
            Load(*load, level, math.radians(settings.get("down_deg", 0.0))) if load else None,
            np.array(sent[0]) if sent else None,
        )
        name = "measured" if path is None else path.stem
        measured = busy("trying servos", lambda _: servo_of_test(test, kind, name=name))
    show_json(answer(measured, test)) if as_json else show(measured, test)
    if path is None:
        return
    remark = "" if measured.verdict.describes else verdict_text(measured, test.noise_rad)
    if remark and not anyway:
        raise sn.SerpenoidError(
            f"{path} is not written: the model does not describe the table. Look at its columns "
            "and units, or give --load; --anyway writes the file with a remark"
        )
    sn.save_servo(replace(measured.kind, remark=remark), path)
    if not as_json:
        say(f"Written: {path}; give it to other commands with --servo {path}.")


def verdict_text(measured: MeasuredServo, noise_rad: float) -> str:
    """Return the verdict in a sentence."""
    verdict = measured.verdict
    p_value = f"p {verdict.p_value:.2g}"
    if verdict.describes:
        return f"The model of a servo describes the table ({p_value})."
    return (
        f"The model of a servo does NOT describe the table ({p_value}): residuals average "
        f"{math.degrees(verdict.worst_rad):+.2g} deg near {verdict.worst_s:.3g} s, and the noise "
        f"of one reading is {math.degrees(noise_rad):.2g} deg."
    )


def notes(measured: MeasuredServo) -> list[str]:
    """Return in words what is open, what is far from usual, and what pulls unstated."""
    from ...servos.bench_fit import FAR_SIGMAS
    from ...servos.bench_test import UNSTATED_LOAD

    lines = ["Open: " + ", ".join(measured.open) + "."] if measured.open else []
    if measured.outside:
        unusual = ", ".join(
            f"{name} ({sigmas:+.1f} sigma)" for name, sigmas in measured.outside.items()
        )
        lines.append(f"Far from what is usual: {unusual}.")
    pulls = [value for name, value in measured.determined.items() if name in UNSTATED_LOAD]
    pull = max(pulls, key=lambda value: abs(value.value) / value.sigma, default=None)
    if pull is not None and abs(pull.value) > FAR_SIGMAS * pull.sigma:
        lines.append(
            f"Something pulls the joint with {abs(pull.value):.2g} of the motor's torque: if a "
            "load hangs on it, give --load KG M, which shows the torque itself."
        )
    return lines


def answer(measured: MeasuredServo, test: BenchTest) -> dict[str, Any]:
    """Return what --json prints."""
    verdict = measured.verdict
    return {
        "describes": verdict.describes,
        "p_value": verdict.p_value,
        "verdict": verdict_text(measured, test.noise_rad),
        "worst": {"t_s": verdict.worst_s, "residual_rad": verdict.worst_rad},
        "noise_rad": test.noise_rad,
        "name": measured.kind.name,
        "servo": asdict(measured.kind.servo),
        "readings": test.t_s.size,
        "determined": {name: value._asdict() for name, value in measured.determined.items()},
        "open": measured.open,
        "outside": measured.outside,
        "notes": notes(measured),
    }


def show(measured: MeasuredServo, test: BenchTest) -> None:
    """Print the verdict, how fast the servo is, what was measured of it, and what is open."""
    from ...base.rows import Row, ranged, two_digits
    from ...show import report

    report.console.print(verdict_text(measured, test.noise_rad))
    no_load = measured.values["no_load_rad_s"]
    report.console.print(
        "Without load the servo turns at about "
        f"{ranged(no_load.value, 'rad/s', no_load.low, no_load.high)}: "
        f"{two_digits(math.pi / 3 / no_load.value)} s for 60°."
    )
    rows = [Row(name, "", *value[:3]).cells for name, value in measured.determined.items()]
    report.table(measured.kind.source, ["measured", "typical", "95 %"], rows)
    for note in notes(measured):
        report.console.print(note)
