"""The commands on a gait: steady, sweep and optimize."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import click

import serpenoid as sn

from ..base.checks import NOT_NEGATIVE, POSITIVE, Limits
from ..base.errors import BadInput
from ..show.screen import say
from .declare import (
    SETTINGS,
    OutFile,
    Setting,
    Values,
    command,
    flag,
    group_settings,
    number,
    option,
    parsed_number,
    plain_text,
    settings,
)
from .options import (
    IDEAL,
    Snake,
    busy,
    describe,
    make_gait,
    make_snake,
    print_result,
    refuse_springs,
    show_json,
    typed_servo,
    warn_of_two_motions,
)

if TYPE_CHECKING:
    from ..prediction.speeds import SpeedBand


@command()
@settings("robot", "friction", "offset", "plug", "springs", "rtol")
@flag(
    "--sensitivities",
    "Changes of the speed by 1 % of each of seven numbers, with ideal joints.",
    research=True,
)
def steady(
    robot: str | None,
    servo: str | None,
    settings: Values,
    formulation: str | None,
    sensitivities: bool,
    verbose: bool,
    as_json: bool,
    **typed_gait: Any,
) -> None:
    """Find the steady motion of one gait: speed, powers, settling time, losses.

    The figures are those of joints that follow the gait exactly. The speed with servos is added,
    with hobby servos unless --servo says which; `--servo ideal` leaves it out.
    """
    from ..show import report

    snake = make_snake(robot, settings)
    body = snake.robot, snake.ground, make_gait(settings | typed_gait)
    springs = group_settings(settings, "springs")
    rtol = settings.get("rtol", 1e-6)
    typed = {"gait": describe(body[2])}
    if formulation == "implicit":
        if sensitivities or servo not in (None, IDEAL):
            raise click.UsageError(
                "--servo and --sensitivities are of the exact model; leave --formulation implicit "
                "out"
            )
        soft = busy("solving", lambda _: sn.steady_springs(*body, rtol=rtol, **springs))
        return print_result(soft, as_json, verbose, typed | snake.notes)
    refuse_springs(settings)
    kind = typed_servo(servo, settings, snake)

    def solved(show_share: Callable[[float], object]) -> tuple[Expected, sn.SpeedLosses]:
        state = sn.steady_gait(*body, rtol=rtol, sensitivities=sensitivities)
        return expect(snake, state, kind, show_share), sn.speed_losses(*body)

    expected, losses = busy("solving", solved)
    state = warn_of_two_motions(expected.state)
    if doubt := state.power_doubt_text(rtol):
        warnings.warn(doubt, stacklevel=2)
    if as_json:
        values = typed | state.to_dict() | {"losses": losses.to_dict()} | snake.notes
        return show_json(values | expected.to_dict())
    report.warn(losses.warning)
    parts = filter(None, (state, expected.servo, losses))
    report.show(*parts, answer=expected.in_words(), verbose=verbose)
    if state.sensitivities is not None:
        report.show(state.sensitivities, verbose=verbose)
    return None


class Expected(NamedTuple):
    """The predicted speed of a gait: with ideal joints, with servos, and with the band of a fit."""

    state: sn.Steady
    servo: sn.ServoSteady | None
    band: SpeedBand | None

    @property
    def best(self) -> SpeedBand | sn.ServoSteady | sn.Steady:
        """Return the best prediction: a fit's band, else with servos, else with ideal joints."""
        follows = self.servo is None or self.servo.follows
        return (follows and self.band) or self.servo or self.state

    def in_words(self) -> str:
        """Return the predicted speed in a sentence."""
        words = self.best.in_words()
        return f"Predicted: {words}." if self.best is self.band else words

    def to_dict(self) -> Values:
        """Return the speed with servos and the band, for JSON."""
        parts = {"servo": self.servo, "band": self.band}
        return {name: part.to_dict() for name, part in parts.items() if part is not None}


def expect(
    snake: Snake,
    state: sn.Steady,
    servo: sn.ServoKind | None,
    show_share: Callable[[float], object] | None = None,
    **samples: int,
) -> Expected:
    """Return the predicted speed of a gait; warns if it does not settle with servos.

    show_share: called with the share of the work done, 0 to 1. samples: `draws`, the number of
    sampled servos of an uncertain kind; with a fit they are in the band instead.
    """
    from ..periodic.servo_steady import with_servo
    from ..prediction.speeds import speed_band

    moved, band = None, None
    if snake.fit:
        band, samples = speed_band(snake.fit, state.gait, servo=servo), {"draws": 0}
    if servo is not None:
        try:
            moved = with_servo(state, servo, progress=show_share, **samples)
        except sn.NotConverged as error:
            warnings.warn(str(error), stacklevel=2)
            moved = error.best
    return Expected(state, moved, band)


MAX_GAITS = 1_000_000  # Largest grid; its answer takes a gigabyte.
span = partial(option, metavar="FIRST:LAST:STEP")


def _span(text: str, name: str) -> list[float]:
    """Return the numbers of FIRST:LAST:STEP, or one number; raises BadInput."""
    numbers = [parsed_number(name, part) for part in text.split(":")]
    if len(numbers) == 1:
        return numbers
    with suppress(ValueError, ArithmeticError):
        first, last, step = numbers
        count = int((last - first) / step + 1 + 1e-9)
        if step > 0 and 1 <= count <= MAX_GAITS:
            return [first + i * step for i in range(count)]
    raise BadInput(
        f"{name} is {text!r}; it must be one number, or FIRST:LAST:STEP that goes upwards in at "
        f"most {MAX_GAITS:g} steps, such as 5:75:5"
    )


@command()
@span("--alpha-deg", "Amplitudes of the joints, in degrees.", default="5:75:5")
@span("--beta-deg", "Phase lags from joint to joint, in degrees.", default="20:90:5")
@span("--frequency-hz", "Cycles of the gaits a second.")
@span("--omega-rad-s", "Angular rates, in place of frequencies; 1:20:1 unless given.")
@option(
    "--out",
    "path",
    "CSV (degrees, hertz) or npz (SI units) to write.",
    type=OutFile(".csv", ".npz"),
)
@settings("robot", "friction", "plug", "rtol")
@option(
    "--scheduler",
    "Solve on the Dask cluster with this address, e.g. tcp://10.0.0.1:8786.",
    metavar="ADDRESS",
    research=True,
)
def sweep(
    robot: str | None,
    servo: str | None,
    settings: Values,
    as_json: bool,
    path: Path | None,
    alpha_deg: str,
    beta_deg: str,
    omega_rad_s: str | None,
    frequency_hz: str | None,
    scheduler: str | None,
) -> None:
    """Solve all gaits of a grid, by default the paper's 4500, and show the fastest and cheapest.

    Joints follow the gaits exactly. --servo adds the speed with servos and its 95 % band, at half
    a second a gait; powers stay those of ideal joints.
    """
    from ..show.sweep_files import write_sweep

    snake = make_snake(robot, settings)
    kind = typed_servo(servo or IDEAL, settings, snake)
    if frequency_hz is not None and omega_rad_s is not None:
        raise click.UsageError("--omega-rad-s and --frequency-hz say the same; give one")
    alphas_deg, betas_deg = _span(alpha_deg, "--alpha-deg"), _span(beta_deg, "--beta-deg")
    if frequency_hz is None:
        rates = [{"omega_rad_s": x} for x in _span(omega_rad_s or "1:20:1", "--omega-rad-s")]
    else:
        rates = [{"hertz": x} for x in _span(frequency_hz, "--frequency-hz")]
    count = len(alphas_deg) * len(betas_deg) * len(rates)
    if count > MAX_GAITS:
        raise click.UsageError(
            f"{count:.3g} gaits are too many for one answer, which holds up to {MAX_GAITS:.3g}; "
            "take larger steps, or sweep one part after the other"
        )
    how = group_settings(settings, "rtol") | {"scheduler": scheduler, "servo": kind}
    how["alpha_rad"] = [sn.Gait.degrees(x, 0.0, **rates[0]).alpha_rad for x in alphas_deg]
    how["beta_rad"] = [sn.Gait.degrees(0.0, x, **rates[0]).beta_rad for x in betas_deg]
    how["omega_rad_s"] = [sn.Gait.degrees(0.0, 0.0, **rate).omega_rad_s for rate in rates]
    solved, total = [], count * (1 if kind is None else 2)

    def solve(show_share: Callable[[float], object]) -> sn.Sweep:
        def advance(gaits: float) -> None:
            solved.append(gaits)
            show_share(sum(solved) / total)

        return sn.sweep(snake.robot, snake.ground, progress=advance, **how)

    states = busy("solving", solve)
    if path is not None:
        write_sweep(states, path)
        say(f"wrote {count} gaits to {path}", err=True)
    show_json(states.to_dict() | snake.notes) if as_json else say(states.in_words())


SETTINGS["limits"] = (  # The fields of GaitLimits, whose angles are in radians
    Setting("joint_angle_deg", "largest joint angle", "deg", Limits(0, 180, open_low=True), "90"),
    Setting(
        "servo_speed_deg_s",
        "largest speed of a servo; inf: no limit",
        "deg/s",
        usual="90 % of its no-load speed",
    ),
    Setting("servo_torque_nm", "largest torque of a servo", "N m", POSITIVE, "no limit"),
    Setting("omega_low_rad_s", "lowest rate of the gait", "rad/s", NOT_NEGATIVE, "the search's"),
    Setting("omega_high_rad_s", "highest rate of the gait", "rad/s", POSITIVE, "the search's"),
)
SETTINGS["cost"] = (
    Setting(
        "cost",
        "mean power to minimise: power, abs_power or positive_power",
        usual="power",
        read=plain_text,
    ),
)


@command()
@number("--speed-m-s", "--speed", "Wanted speed.", required=True)
@flag("--ideal", "The paper's optimum: without the robot's limits.")
@settings("robot", "friction", "plug", "limits", "cost")
def optimize(
    robot: str | None,
    speed_m_s: float,
    servo: str | None,
    settings: Values,
    ideal: bool,
    formulation: str | None,
    verbose: bool,
    as_json: bool,
) -> None:
    """Find the gait that reaches a speed with least power, and that the robot can run.

    Joints stay within the board's 90 degrees, and servos can follow: hobby servos unless --servo or
    a session says which. The gait keeps 80 % of its speed with 10 % less amplitude, and with 20 %
    less friction across the links; if none does, it is the one that loses least. --ideal leaves
    these limits out.
    """
    from ..servos.speed_limit import too_fast_text
    from ..show import report
    from ..show.gaits.gait_report import beside_ideal

    snake = make_snake(robot, settings)
    body = snake.robot, snake.ground
    kind = typed_servo(servo, settings, snake)
    request: Values = {"speed_m_s": speed_m_s, "formulation": formulation or "explicit"}
    request |= group_settings(settings, "cost")

    def searched(_: object) -> tuple[sn.LeastPower, sn.LeastPower | None]:
        best = sn.least_power_gait(*body, limits=_limits(settings, ideal, kind), **request)
        with suppress(sn.NotConverged):
            return best, None if ideal else sn.least_power_gait(*body, **request)
        return best, None

    best, paper = busy("searching", searched)
    best = replace(best, steady=warn_of_two_motions(best.steady))
    expected = busy("servos", lambda share: expect(snake, best.steady, kind, share))
    if as_json:
        values = _as_dict(best) | best.steady.to_dict() | {"ideal": paper and _as_dict(paper)}
        return show_json(values | expected.to_dict() | snake.notes)
    report.warn(best.losses.warning)
    words = f"{best.in_words()} {expected.in_words()}"
    if paper is None:
        report.warn(too_fast_text(best.gait, kind or sn.servo("hobby")))
    else:
        words += f" {beside_ideal(best, paper, kind)}"
    report.show(*filter(None, (best, expected.servo)), answer=words, verbose=verbose)
    typed = [f"--{k.replace('_', '-')} {v:.4g}" for k, v in describe(best.gait).items() if v]
    named = [f"--robot {robot}"] if robot else []
    say(f"drive it: serpenoid drive {' '.join(named + typed)}")
    return None


def _limits(settings: Values, ideal: bool, kind: sn.ServoKind | None) -> sn.GaitLimits:
    """Return the limits of a search: those that are set, and the robot's unless ideal.

    The robot's limits are those of a new board, of its servos, and of the speed to be kept.
    """
    from ..servos.speed_limit import MAX_NO_LOAD_SHARE, no_load_rad_s

    limits = {}
    if not ideal:  # The limits of a new board, and the share of the speed to be kept.
        limits = {"joint_angle_deg": 90.0, "servo_speed_deg_s": 500.0, "kept_speed_share": 0.8}
    if kind is not None and not ideal:
        # The result of the search may exceed the limit by 1e-4.
        followed_deg_s = (1 - 1e-4) * MAX_NO_LOAD_SHARE * math.degrees(no_load_rad_s(kind))
        limits["servo_speed_deg_s"] = min(limits["servo_speed_deg_s"], followed_deg_s)
    values = {
        name.replace("_deg", "_rad"): math.radians(limit) if "_deg" in name else limit
        for name, limit in (limits | group_settings(settings, "limits")).items()
    }
    return sn.GaitLimits(**values)


def _as_dict(best: sn.LeastPower) -> Values:
    """Return a gait with its cost and losses, for JSON."""
    return {
        "gait": describe(best.gait),
        "cost": best.cost,
        "formulation": best.formulation,
        "cost_w": best.power_w,
        "cost_error_w": best.power_error_w,
        "solved_error_w": best.solved_error_w,
        "active": best.active,
        "losses": best.losses.to_dict(),
    }
