"""`serpenoid servo`: a servo's file from a bench test of one joint."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import serpenoid as sn

from ...base.checks import Limits, check_choice
from ...base.rows import Result, Row, ranged, two_digits
from ...show.screen import say
from ..declare import (
    EXISTING,
    SETTINGS,
    OutFile,
    Setting,
    Values,
    command,
    flag,
    number,
    option,
    settings,
)
from ..options import busy, print_result, servo_kind

if TYPE_CHECKING:
    from ...servos.bench_fit import MeasuredServo

SETTINGS["bench"] = (
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
@option("--like", "Kind of servo that it is.", default="hobby", metavar="NAME|FILE")
@number(
    "--load",
    "What the joint turns: mass, and distance of its centre from the axis.",
    nargs=2,
    metavar="KG M",
)
@flag("--anyway", "Write the file of a test that the model does not describe, with a remark.")
@option("--out", "path", "File to write, for --servo of other commands.", type=OutFile(".toml"))
@settings("plug", "bench")
def servo(
    table: Path,
    like: str,
    load: tuple[float, float] | None,
    anyway: bool,
    path: Path | None,
    settings: Values,
    as_json: bool,
) -> None:
    """Measure a servo by a bench test of one joint, and tell whether the model describes it.

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
    columns = number_columns(table, ("t_s", "setpoint_deg", "angle_deg"), ("sent_s",))
    t, setpoint, angle, *sent = columns.values()
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
    answer = Answer(measured, test.noise_rad)
    print_result(answer, as_json, True, {})
    if path is None:
        return
    remark = "" if measured.verdict.describes else answer.verdict_text
    if remark and not anyway:
        raise sn.SerpenoidError(
            f"{path} is not written: the model does not describe the table. Look at its columns "
            "and units, or give --load; --anyway writes the file with a remark"
        )
    sn.save_servo(replace(measured.kind, remark=remark), path)
    if not as_json:
        say(f"Written: {path}; give it to other commands with --servo {path}.")


@dataclass(frozen=True, repr=False)
class Answer(Result):
    """What a bench test says of a servo, to print."""

    measured: MeasuredServo
    noise_rad: float

    @property
    def verdict_text(self) -> str:
        """Return the verdict in a sentence."""
        verdict = self.measured.verdict
        p_value = f"p {verdict.p_value:.2g}"
        if verdict.describes:
            return f"The model of a servo describes the table ({p_value})."
        return (
            f"The model of a servo does NOT describe the table ({p_value}): residuals average "
            f"{math.degrees(verdict.worst_rad):+.2g} deg near {verdict.worst_s:.3g} s, and the "
            f"noise of one reading is {math.degrees(self.noise_rad):.2g} deg."
        )

    def in_words(self) -> str:
        """Return the verdict, how fast the servo is, what is open or unusual, and what pulls."""
        from ...servos.bench_fit import FAR_SIGMAS
        from ...servos.bench_test import UNSTATED_LOAD

        measured = self.measured
        no_load = measured.values["no_load_rad_s"]
        speed = ranged(no_load.value, "rad/s", no_load.low, no_load.high)
        lines = [
            self.verdict_text,
            f"Without load the servo turns at about {speed}: "
            f"{two_digits(math.pi / 3 / no_load.value)} s for 60°.",
        ]
        if measured.open:
            lines.append(f"Open: {', '.join(measured.open)}.")
        if measured.outside:
            sigmas = [f"{name} ({count:+.1f} sigma)" for name, count in measured.outside.items()]
            lines.append(f"Far from what is usual: {', '.join(sigmas)}.")
        loads = [measured.determined[name] for name in UNSTATED_LOAD.keys() & measured.determined]
        if pulls := [abs(x.value) for x in loads if abs(x.value) > FAR_SIGMAS * x.sigma]:
            lines.append(
                f"Something pulls the joint with {max(pulls):.2g} of the motor's torque: if a "
                "load hangs on it, give --load KG M, which shows the torque itself."
            )
        return "\n".join(lines)

    def rows(self) -> list[Row]:
        """Return what the test determines: median and interval."""
        return [Row(name, "", *value[:3]) for name, value in self.measured.determined.items()]

    def to_dict(self) -> Values:
        """Return what --json prints."""
        measured, verdict = self.measured, self.measured.verdict
        return {
            "describes": verdict.describes,
            "p_value": verdict.p_value,
            "verdict": self.verdict_text,
            "worst": {"t_s": verdict.worst_s, "residual_rad": verdict.worst_rad},
            "noise_rad": self.noise_rad,
            "name": measured.kind.name,
            "servo": asdict(measured.kind.servo),
            "determined": {name: value._asdict() for name, value in measured.determined.items()},
            "open": measured.open,
            "outside": measured.outside,
        }
