"""The command `serpenoid sweep`: every gait of a grid."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import click

import serpenoid as sn

from ...base.errors import BadInput
from ...show.screen import say
from ..declare import (
    Given,
    Setting,
    command,
    option,
    out_file,
    parsed_number,
    parsed_whole,
    settings,
)
from ..given import make_snake, take_servo
from ..options import (
    AS_JSON,
    FRICTION,
    IDEAL,
    PLUG,
    ROBOT,
    RTOL,
    busy,
    robot_option,
    servo_option,
    show_json,
)

SUFFIXES = (".csv", ".npz")
MAX_VALUES = 100_000  # of a range
MAX_GAITS = 1_000_000  # of an answer: its text takes a gigabyte


def _span(text: str, name: str) -> list[float]:
    """Read FIRST:LAST:STEP, or one number."""
    numbers = [parsed_number(name, part) for part in text.split(":")]
    if len(numbers) == 1:
        return numbers
    first, last, step = numbers if len(numbers) == 3 else (0.0, 0.0, 0.0)
    if not (last >= first and step > 0 and (last - first) / step < MAX_VALUES):
        raise BadInput(
            f"{name} is {text!r}; it must be one number, or FIRST:LAST:STEP that goes upwards in "
            f"at most {MAX_VALUES} steps, such as 5:75:5"
        )
    return [first + i * step for i in range(int((last - first) / step + 1 + 1e-9))]


THREADS = Setting("threads", "threads to solve in", usual="1 a core", read=parsed_whole)


@command()
@robot_option
@option("--alpha-deg", "FIRST:LAST:STEP.", default="5:75:5")
@option("--beta-deg", "FIRST:LAST:STEP.", default="20:90:5")
@option("--frequency-hz", "FIRST:LAST:STEP.")
@option("--omega-rad-s", "FIRST:LAST:STEP, in place of the frequency; 1:20:1 unless given.")
@servo_option
@option(
    "--out",
    "CSV (degrees, hertz) or npz (SI units) to write.",
    type=out_file(*SUFFIXES),
)
@settings(*ROBOT, *FRICTION, *PLUG, RTOL, THREADS)
@option(
    "--scheduler",
    "Solve on the Dask cluster with this address, e.g. tcp://10.0.0.1:8786.",
    metavar="ADDRESS",
    research=True,
)
@AS_JSON
def sweep(
    robot: str | None,
    servo: str | None,
    settings: Given,
    as_json: bool,
    out: Path | None,
    alpha_deg: str,
    beta_deg: str,
    omega_rad_s: str | None,
    frequency_hz: str | None,
    scheduler: str | None,
) -> None:
    """Solve every gait of a grid (the paper's 4500 unless told): the fastest, the cheapest metre.

    Joints follow the gaits exactly. --servo adds the speed with servos and its 95 % band, at half
    a second a gait; powers stay those of ideal joints.
    """
    kind = take_servo(servo or IDEAL, settings)
    snake = make_snake(robot, settings)
    if frequency_hz is not None and omega_rad_s is not None:
        raise click.UsageError("--omega-rad-s and --frequency-hz say the same; give one")
    alphas_deg, betas_deg = _span(alpha_deg, "--alpha-deg"), _span(beta_deg, "--beta-deg")
    hertz = [] if frequency_hz is None else _span(frequency_hz, "--frequency-hz")
    grid = {
        "alpha_rad": [sn.Gait.degrees(a, 0.0, hertz=1.0).alpha_rad for a in alphas_deg],
        "beta_rad": [sn.Gait.degrees(0.0, b, hertz=1.0).beta_rad for b in betas_deg],
        "omega_rad_s": [math.tau * hz for hz in hertz]
        or _span(omega_rad_s or "1:20:1", "--omega-rad-s"),
    }
    from ...show.sweep_files import write_sweep

    count = math.prod(map(len, grid.values()))
    if count > MAX_GAITS:
        raise click.UsageError(
            f"{count:.3g} gaits are too many for one answer, which holds up to {MAX_GAITS:.3g}; "
            "take larger steps, or sweep one part after the other"
        )
    how = {name: settings[name] for name in ("rtol", "threads") if name in settings}
    how |= {"scheduler": scheduler, "servo": kind, **grid}
    solved, whole = [], count * (1 if kind is None else 2)

    def solve(show_share: Callable[[float], object]) -> sn.Sweep:
        def advance(gaits: float) -> None:
            solved.append(gaits)
            show_share(sum(solved) / whole)

        return sn.sweep(snake.robot, snake.ground, progress=advance, **how)

    states = busy("solving", solve)
    if out is not None:
        write_sweep(states, out)
        say(f"wrote {count} gaits to {out}", err=True)
    show_json(states.to_dict() | snake.notes) if as_json else say(states.in_words())
