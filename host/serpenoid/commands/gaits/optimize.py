"""The command `serpenoid optimize`: the gait of least power at a speed, onto the robot if asked."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar

import click

import serpenoid as sn

from ...base.checks import NOT_NEGATIVE, POSITIVE, Limits, check_number
from ...show.screen import working
from ..board.tools import PORT
from ..declare import (
    Command,
    Given,
    Number,
    Setting,
    flag,
    option,
    out_file,
    parsed_number,
    refuse_typed,
    settings,
)
from ..given import Snake, make_snake, predicted_band, servo_remark, take_servo
from ..options import (
    AS_TABLES,
    FRICTION,
    IDEAL,
    PLUG,
    ROBOT,
    describe,
    formulation_option,
    interruptible,
    robot_option,
    servo_option,
    show_json,
    warn_of_two_motions,
)
from .steady import beside_servo, few_links, speed_in_words, speeds_as_dict

_Result = TypeVar("_Result")
_BOARD_ANGLE_DEG, _BOARD_SPEED_DEG_S = 90.0, 500.0  # a new board's own limits
_KEPT_SPEED_SHARE = 0.8  # with 10 % less amplitude, and with 20 % less friction across
_SPEED_ROUNDING = 1e-4  # relative: a search may end this far beyond a limit

# Keys of answers, in their order; each is an attribute's name, or stands here beside it.
_KEYS = {"cost_w": "power_w", "cost_error_w": "power_error_w"}
_OF_LEAST_POWER = (
    "gait",
    "cost",
    "formulation",
    "cost_w",
    "cost_error_w",
    "solved_error_w",
    "active",
)
LIMITS = (  # The fields of GaitLimits, whose angles are in radians
    Setting("joint_angle_deg", "most a joint may bend", "deg", Limits(0, 180, open_low=True), "90"),
    Setting(
        "servo_speed_deg_s",
        "most a servo turns; inf: no limit",
        "deg/s",
        Limits(1e-3),
        "90 % of its no-load speed",
        read=lambda name, text: math.inf if text == "inf" else parsed_number(name, text),
    ),
    Setting("servo_torque_nm", "most a servo holds", "N m", POSITIVE, "no limit"),
    Setting("omega_low_rad_s", "lowest rate of the gait", "rad/s", NOT_NEGATIVE, "the search's"),
    Setting("omega_high_rad_s", "highest rate of the gait", "rad/s", POSITIVE, "the search's"),
)
COST = Setting(
    "cost",
    "mean power to make least",
    limits=("power", "abs_power", "positive_power"),
    usual="power",
)


@click.command(cls=Command)
@robot_option
@option(
    "--speed-m-s",
    "--speed",
    "speed_m_s",
    "Wanted speed; several, with commas, give the whole front.",
    required=True,
    metavar="M/S[,M/S...]",
)
@servo_option
@flag("--ideal", "The paper's optimum: without the robot's limits.")
@flag("--send", "Drive the gait on the robot, as `drive` does.")
@PORT
@option(
    "--duration-s",
    "With --send: how long; until Ctrl-C unless given.",
    type=Number(0, open_low=True),
)
@option("--record", "With --send: new file for the run's lines.", type=out_file())
@settings(*ROBOT, *FRICTION, *PLUG, *LIMITS, COST)
@formulation_option
@AS_TABLES
def optimize(
    robot: str | None,
    speed_m_s: str,
    servo: str | None,
    settings: Given,
    ideal: bool,
    send: bool,
    formulation: str,
    verbose: bool,
    as_json: bool,
    **run: Any,
) -> None:
    """Find the gait of least power at a speed that the robot can be driven with.

    Its joints stay within the board's 90 degrees, and its servos follow it: hobby servos unless
    --servo or a session says which. It keeps 80 % of its speed when the joints' amplitude is 10 %
    less, or friction across the links 20 % less; where no gait does, it is one that loses least.
    --ideal leaves these limits out.
    """
    wanted = _speeds(speed_m_s)
    if not send:
        refuse_typed("{} is for --send, which is not there", *run)
    if len(wanted) > 1 and (send or servo):
        raise click.UsageError("--send and --servo take one speed")
    if send:
        _check_board(**run)
    snake = make_snake(robot, settings)
    body = snake.robot, snake.ground
    kind = take_servo(servo, settings, IDEAL if snake.fit is None else "hobby", snake)
    if servo is None and kind is None and (few_links(snake.robot) or not ideal):
        kind = take_servo("hobby", settings, IDEAL)
    how = {"cost": settings.get("cost", "power"), "formulation": formulation}
    limits = _limits(settings, ideal, send, kind)
    if len(wanted) > 1:
        front = _searched(lambda: sn.power_front(*body, speeds_m_s=wanted, limits=limits, **how))
        return _show_front(wanted, front, as_json, snake.notes)
    best = _searched(lambda: sn.least_power_gait(*body, speed_m_s=wanted[0], limits=limits, **how))
    paper = None if ideal else _papers_optimum(snake, wanted[0], how)
    best = replace(best, steady=warn_of_two_motions(best.steady))
    with working("servos") as show_share:
        shown = kind if few_links(snake.robot) else None
        moved = beside_servo(best.steady, shown, snake.fit is None, show_share)
    # what is sent is predicted when it is driven
    band = interruptible(lambda: None if send else predicted_band(snake, best.gait, kind))
    answer = _as_dict(best) | {"ideal": None if paper is None else _ideal_dict(paper)}
    answer |= speeds_as_dict(moved, band)
    answer |= snake.notes | servo_remark(kind)
    if not as_json:
        words = speed_in_words(best.steady, moved, band)
        _show(best, paper, moved, kind, words, verbose)
    if send:
        from ..board.driving import drive_gait

        drive_gait(best.gait, as_json, snake, before=answer, servo=kind, **run)
    elif as_json:
        show_json(answer)
    return None


def _check_board(port: str | None, record: Path | None, **_: Any) -> None:
    """Find the board and the recording's place before the search, not after it."""
    from ...robot.recording.recorder import check_free
    from ...robot.wire.ports import find_port

    if record is not None:
        check_free(record)
    if port is None:
        find_port()


def _papers_optimum(snake: Snake, speed_m_s: float, how: Given) -> sn.LeastPower | None:
    """Return the gait of least power without the robot's limits."""
    with suppress(sn.NotConverged):
        return _searched(
            lambda: sn.least_power_gait(snake.robot, snake.ground, speed_m_s=speed_m_s, **how)
        )
    return None


def _show(
    best: sn.LeastPower,
    paper: sn.LeastPower | None,
    moved: sn.ServoSteady | None,
    kind: sn.ServoKind | None,
    speed: str,
    verbose: bool,
) -> None:
    """Print the answer: gait, speed, what limits it, and the paper's optimum; then the figures."""
    from ...show import report
    from ...show.gaits import gait_report

    gait_report.warn_of_losses(best.losses)
    words = f"{best.in_words()} {speed}"
    if paper is None:
        gait_report.warn_too_fast(best.gait, kind or sn.servo("hobby"))
    else:
        words += f" {gait_report.beside_ideal(best, paper, kind)}"
    report.show(best, *([moved] if moved else []), answer=words, verbose=verbose)


def _limits(settings: Given, ideal: bool, send: bool, kind: sn.ServoKind | None) -> sn.GaitLimits:
    """Return the limits of a search: those set, else the robot's.

    The robot's are those of a new board, of servos that are to follow, and of the speed that is to
    be kept; ideal: none of them, but the board's with send, as it refuses others.
    """
    from ...servos.speed_limit import MAX_NO_LOAD_SHARE, no_load_rad_s

    limits: Given = {}
    if send or not ideal:
        limits["joint_angle_rad"] = math.radians(_BOARD_ANGLE_DEG)
        limits["servo_speed_rad_s"] = math.radians(_BOARD_SPEED_DEG_S)
    if not ideal:
        limits["kept_speed_share"] = _KEPT_SPEED_SHARE
        if kind is not None:
            followed_rad_s = (1 - _SPEED_ROUNDING) * MAX_NO_LOAD_SHARE * no_load_rad_s(kind)
            limits["servo_speed_rad_s"] = min(limits["servo_speed_rad_s"], followed_rad_s)
    for setting in LIMITS:
        if setting.name in settings:
            value, name = settings[setting.name], setting.name.replace("_deg", "_rad")
            limits[name] = math.radians(value) if name != setting.name else value
    return sn.GaitLimits(**limits)


def _speeds(text: str) -> list[float]:
    try:
        speeds = [float(part) for part in text.split(",")]
    except ValueError:
        raise click.BadParameter(
            f"{text!r} is not a speed, nor speeds with commas", param_hint="--speed-m-s"
        ) from None
    return [check_number("--speed-m-s", speed, 0.0, open_low=True) for speed in speeds]


def _searched(work: Callable[[], _Result]) -> _Result:
    """Return work() and show that it goes on; Ctrl-C ends both, so this thread shows it."""
    with working("searching"):
        return interruptible(work)


def _as_dict(best: sn.LeastPower) -> Given:
    answer = {name: getattr(best, _KEYS.get(name, name)) for name in _OF_LEAST_POWER}
    answer |= {"gait": describe(best.gait), "losses": best.losses.to_dict()}
    return answer | best.steady.to_dict()


def _ideal_dict(paper: sn.LeastPower) -> Given:
    """Return the gait of the paper's optimum, its cost and what it loses."""
    answer = {"gait": describe(paper.gait), "cost_w": paper.power_w}
    return answer | {"losses": paper.losses.to_dict()}


def _show_front(
    speeds: list[float], front: Sequence[sn.LeastPower | None], as_json: bool, notes: Given
) -> None:
    from ...show.gaits import gait_report

    if all(best is None for best in front):
        raise sn.NotConverged(
            f"no gait reaches {min(speeds):g} m/s within the limits; ask for less speed"
        )
    if as_json:
        optima = [None if best is None else _as_dict(best) for best in front]
        show_json({"front": optima} | notes)
    else:
        gait_report.front(speeds, front)
