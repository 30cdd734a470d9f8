"""The commands on a gait: steady, sweep and optimize."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

import serpenoid as sn

from ..base.checks import NOT_NEGATIVE, POSITIVE, Limits
from ..base.errors import BadInput
from ..show.screen import say
from .declare import (
    OutFile,
    Setting,
    Values,
    chosen,
    command,
    flag,
    number,
    option,
    parsed_number,
    refuse_unused,
    settings,
)
from .options import (
    AS_JSON,
    AS_TABLES,
    FRICTION,
    IDEAL,
    OFFSET,
    PINNED,
    PLUG,
    ROBOT,
    RTOL,
    SPRINGS,
    Snake,
    busy,
    describe,
    formulation_option,
    gait_options,
    make_gait,
    make_snake,
    robot_option,
    servo_option,
    show_json,
    take_servo,
    tell,
    warn_of_two_motions,
)

if TYPE_CHECKING:
    from ..prediction.band import SpeedBand


FEW_LINKS = 20  # servos are asked about unasked: the work grows as the cube of the links
SERVO_DRAWS = 512  # servos of an uncertain kind, for the interval that they leave


@command()
@robot_option
@gait_options
@servo_option
@settings(*ROBOT, *FRICTION, OFFSET, *PLUG, *SPRINGS, RTOL)
@formulation_option
@flag(
    "--sensitivities",
    "differentiated",
    "What 1 % more of seven numbers changes of the speed (ideal joints).",
    research=True,
)
@AS_TABLES
def steady(
    robot: str | None,
    servo: str | None,
    settings: Values,
    formulation: str,
    differentiated: bool,
    verbose: bool,
    as_json: bool,
    **typed_gait: Any,
) -> None:
    """Find the periodic state of one gait: speed, powers, settling time, losses.

    The figures are those of joints that follow the gait exactly. Beside them stands the speed with
    servos: with any hobby servo unless --servo says which, or `ideal`.
    """
    from ..show import report
    from ..show.gaits import gait_report

    snake = make_snake(robot, settings)
    body = snake.robot, snake.ground, make_gait(typed_gait, settings)
    springs = chosen(settings, *SPRINGS)
    rtol = settings.get("rtol", 1e-6)
    typed = {"gait": describe(body[2])}
    if formulation == "implicit":
        if differentiated or servo not in (None, IDEAL):
            raise click.UsageError(
                "--servo and --sensitivities are of the exact model; leave --formulation implicit "
                "out"
            )
        soft = busy("solving", lambda _: sn.steady_springs(*body, rtol=rtol, **springs))
        if soft.error_estimate > rtol:
            warnings.warn(
                f"the speed is known to {soft.error_estimate:.1g}, not to the rtol of {rtol:g}: "
                "the time steps of the springs do not give more",
                stacklevel=2,
            )
        return tell(soft, as_json, verbose, typed | snake.notes)
    refuse_unused(settings, PINNED, *springs)
    kind = take_servo(servo or ("hobby" if few_links(snake) else IDEAL), settings, snake)

    def solved(show_share: Callable[[float], object]) -> tuple[Expected, sn.SpeedLosses]:
        state = sn.steady_gait(*body, rtol=rtol, sensitivities=differentiated)
        return expect(snake, state, kind, show_share), sn.speed_losses(*body)

    expected, losses = busy("solving", solved)
    state = warn_of_two_motions(expected.state)
    if doubt := state.power_doubt_text(rtol):
        warnings.warn(doubt, stacklevel=2)
    if as_json:
        values = typed | state.to_dict() | {"losses": losses.to_dict()} | snake.notes
        return show_json(values | expected.to_dict())
    gait_report.warn_of_losses(losses)
    parts = filter(None, (state, expected.servo, losses))
    report.show(*parts, answer=expected.in_words(), verbose=verbose)
    if state.sensitivities is not None:
        report.show(state.sensitivities, verbose=verbose)
    return None


@dataclass(frozen=True)
class Expected:
    """The speed to expect of a gait: with ideal joints, with servos, and the band of a fit."""

    state: sn.Steady
    servo: sn.ServoSteady | None
    band: SpeedBand | None

    @property
    def best(self) -> SpeedBand | sn.ServoSteady | sn.Steady:
        """Return a fit's band, or else what servos leave of the speed."""
        follows = self.servo is None or self.servo.follows
        return (follows and self.band) or self.servo or self.state

    def in_words(self) -> str:
        """Return what a builder may expect."""
        words = self.best.in_words()
        return f"Predicted: {words}." if self.best is self.band else words

    def to_dict(self) -> Values:
        """Return the speed with servos, and the band."""
        parts = {"servo": self.servo, "band": self.band}
        return {name: part.to_dict() for name, part in parts.items() if part is not None}


def expect(
    snake: Snake,
    state: sn.Steady,
    servo: sn.ServoKind | None,
    show_share: Callable[[float], object] | None = None,
    draws: int = SERVO_DRAWS,
) -> Expected:
    """Return the speed to expect; servos that do not settle to one are warned of.

    show_share: called with the share of the work that is done. draws: servos drawn of an uncertain
    kind; with a fit, whose band has servos of its own, none.
    """
    from ..periodic.servo_steady import with_servo
    from ..prediction.band import speed_band

    moved = None
    if servo is not None:
        try:
            moved = with_servo(state, servo, 0 if snake.fit else draws, show_share)
        except sn.NotConverged as error:
            warnings.warn(str(error), stacklevel=2)
            moved = error.best
    band = speed_band(snake.fit, state.gait, servo=servo) if snake.fit else None
    return Expected(state, moved, band)


def few_links(snake: Snake) -> bool:
    """Tell whether servos are asked about unasked."""
    return snake.robot.links <= FEW_LINKS


SUFFIXES = (".csv", ".npz")
SPAN = "FIRST:LAST:STEP"
MAX_VALUES = 100_000  # largest count of values in a range
MAX_GAITS = 1_000_000  # largest grid of an answer, whose text takes a gigabyte


def _span(text: str, name: str) -> list[float]:
    """Read FIRST:LAST:STEP, or one number."""
    numbers = [parsed_number(name, part) for part in text.split(":")]
    if len(numbers) == 1:
        return numbers
    is_span = len(numbers) == len(SPAN.split(":"))
    first, last, step = numbers if is_span else (0.0, 0.0, 0.0)
    if not (step > 0 and last >= first and (last - first) / step < MAX_VALUES):
        raise BadInput(
            f"{name} is {text!r}; it must be one number, or {SPAN} that goes upwards in "
            f"at most {MAX_VALUES} steps, such as 5:75:5"
        )
    return [first + i * step for i in range(int((last - first) / step + 1 + 1e-9))]


THREADS = Setting("threads", "threads to solve in", usual="1 a core")


@command()
@robot_option
@option("--alpha-deg", f"{SPAN}.", default="5:75:5")
@option("--beta-deg", f"{SPAN}.", default="20:90:5")
@option("--frequency-hz", f"{SPAN}.")
@option("--omega-rad-s", f"{SPAN}, in place of the frequency; 1:20:1 unless given.")
@servo_option
@option(
    "--out",
    "path",
    "CSV (degrees, hertz) or npz (SI units) to write.",
    type=OutFile(*SUFFIXES),
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
    settings: Values,
    as_json: bool,
    path: Path | None,
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
    snake = make_snake(robot, settings)
    kind = take_servo(servo or IDEAL, settings, snake)
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
    from ..show.sweep_files import write_sweep

    count = math.prod(map(len, grid.values()))
    if count > MAX_GAITS:
        raise click.UsageError(
            f"{count:.3g} gaits are too many for one answer, which holds up to {MAX_GAITS:.3g}; "
            "take larger steps, or sweep one part after the other"
        )
    how = {name: settings[name] for name in ("rtol", "threads") if name in settings}
    how |= {"scheduler": scheduler, "servo": kind, **grid}
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


# Of a new board, and the share of speed kept with 10 % less amplitude or 20 % less friction across.
BOARD_LIMITS = {"joint_angle_deg": 90.0, "servo_speed_deg_s": 500.0, "kept_speed_share": 0.8}
_SPEED_ROUNDING = 1e-4  # relative: a search may end this far beyond a limit
LIMITS = (  # The fields of GaitLimits, whose angles are in radians
    Setting("joint_angle_deg", "most a joint may bend", "deg", Limits(0, 180, open_low=True), "90"),
    Setting(
        "servo_speed_deg_s",
        "most a servo turns; inf: no limit",
        "deg/s",
        usual="90 % of its no-load speed",
    ),
    Setting("servo_torque_nm", "most a servo holds", "N m", POSITIVE, "no limit"),
    Setting("omega_low_rad_s", "lowest rate of the gait", "rad/s", NOT_NEGATIVE, "the search's"),
    Setting("omega_high_rad_s", "highest rate of the gait", "rad/s", POSITIVE, "the search's"),
)
COST = Setting(
    "cost",
    "mean power to make least: power, abs_power or positive_power",
    usual="power",
    read=lambda _name, text: text,
)


@command()
@robot_option
@number("--speed-m-s", "--speed", "Wanted speed.", required=True, limits=POSITIVE)
@servo_option
@flag("--ideal", "The paper's optimum: without the robot's limits.")
@settings(*ROBOT, *FRICTION, *PLUG, *LIMITS, COST)
@formulation_option
@AS_TABLES
def optimize(
    robot: str | None,
    speed_m_s: float,
    servo: str | None,
    settings: Values,
    ideal: bool,
    formulation: str,
    verbose: bool,
    as_json: bool,
) -> None:
    """Find the gait of least power at a speed that the robot can be driven with.

    Its joints stay within the board's 90 degrees, and its servos follow it: hobby servos unless
    --servo or a session says which. It keeps 80 % of its speed when the joints' amplitude is 10 %
    less, or friction across the links 20 % less; where no gait does, it is one that loses least.
    --ideal leaves these limits out.
    """
    from ..show import report
    from ..show.gaits import gait_report

    snake = make_snake(robot, settings)
    body = snake.robot, snake.ground
    usual = "hobby" if few_links(snake) or not ideal else IDEAL
    kind = take_servo(servo or usual, settings, snake)
    request: Values = {"speed_m_s": speed_m_s, "formulation": formulation}
    request["cost"] = settings.get("cost", "power")

    def searched(_: object) -> tuple[sn.LeastPower, sn.LeastPower | None]:
        best = sn.least_power_gait(*body, limits=_limits(settings, ideal, kind), **request)
        with suppress(sn.NotConverged):
            return best, None if ideal else sn.least_power_gait(*body, **request)
        return best, None

    best, paper = busy("searching", searched)
    best = replace(best, steady=warn_of_two_motions(best.steady))
    shown = kind if servo or few_links(snake) else None
    expected = busy("servos", lambda share: expect(snake, best.steady, shown, share))
    if as_json:
        names = {"gait", "cost_w", "losses"}
        ideal_values = paper and {k: v for k, v in _as_dict(paper).items() if k in names}
        values = _as_dict(best) | best.steady.to_dict() | {"ideal": ideal_values}
        return show_json(values | expected.to_dict() | snake.notes)
    gait_report.warn_of_losses(best.losses)
    words = f"{best.in_words()} {expected.in_words()}"
    if paper is None:
        gait_report.warn_too_fast(best.gait, kind or sn.servo("hobby"))
    else:
        words += f" {gait_report.beside_ideal(best, paper, kind)}"
    report.show(*filter(None, (best, expected.servo)), answer=words, verbose=verbose)
    typed = [f"--{k.replace('_', '-')} {v:.4g}" for k, v in describe(best.gait).items() if v]
    named = [f"--robot {robot}"] if robot else []
    say(f"drive it: serpenoid drive {' '.join(named + typed)}")
    return None


def _limits(settings: Values, ideal: bool, kind: sn.ServoKind | None) -> sn.GaitLimits:
    """Return the limits of a search: those set, else the robot's unless ideal.

    The robot's are those of a new board, of servos that are to follow, and of the speed that is to
    be kept.
    """
    from ..servos.speed_limit import MAX_NO_LOAD_SHARE, no_load_rad_s

    limits: Values = {}
    if not ideal:
        limits |= BOARD_LIMITS
        if kind is not None:
            followed_rad_s = (1 - _SPEED_ROUNDING) * MAX_NO_LOAD_SHARE * no_load_rad_s(kind)
            slowest = min(limits["servo_speed_deg_s"], math.degrees(followed_rad_s))
            limits["servo_speed_deg_s"] = slowest
    limits |= chosen(settings, *LIMITS)
    angles = [name for name in limits if "_deg" in name]
    limits |= {name.replace("_deg", "_rad"): math.radians(limits.pop(name)) for name in angles}
    return sn.GaitLimits(**limits)


def _as_dict(best: sn.LeastPower) -> Values:
    """Return a gait with its cost and what it loses."""
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
