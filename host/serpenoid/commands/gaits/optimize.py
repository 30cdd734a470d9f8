"""The command `serpenoid optimize`: the gait of least power at a speed, onto the robot if asked."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
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
from ..given import make_snake, predicted_band, servo_remark, take_servo
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
    "basins",
    "runner_up_w",
)
LIMITS = (  # of GaitLimits, whose angles are in radians
    Setting(
        "joint_angle_deg", "most a joint may bend", "deg", Limits(0, 180, open_low=True), "110"
    ),
    Setting(
        "servo_speed_deg_s",
        "most a servo turns; inf: no limit",
        "deg/s",
        Limits(1e-3),
        "500, a new board's",
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
    send: bool,
    formulation: str,
    verbose: bool,
    as_json: bool,
    **run: Any,
) -> None:
    """Find the gait that costs least power at a speed, and say how near to a cliff it stands.

    Gaits are searched with ideal joints. Beside the speed stands what servos leave of it: any hobby
    servo unless --servo says which, or `ideal`.
    """
    wanted = _speeds(speed_m_s)
    if not send:
        refuse_typed("{} is for --send, which is not there", *run)
    if len(wanted) > 1 and (send or servo):
        raise click.UsageError("--send and --servo take one speed")
    if send:  # board and the recording's place are found before the search, not after it
        from ...robot.recording.recorder import check_free
        from ...robot.wire.ports import find_port

        if run["record"] is not None:
            check_free(run["record"])
        if run["port"] is None:
            find_port()
    snake = make_snake(robot, settings)
    body = snake.robot, snake.ground
    how = {
        "cost": settings.get("cost", "power"),
        "limits": _limits(settings, send),
        "formulation": formulation,
    }
    if len(wanted) > 1:
        front = _searched(lambda: sn.power_front(*body, speeds_m_s=wanted, **how))
        return _show_front(wanted, front, as_json, snake.notes)
    kind = take_servo(servo, settings, IDEAL if snake.fit is None else "hobby", snake)
    if servo is None and few_links(snake.robot) and kind is None:
        kind = take_servo("hobby", settings, IDEAL)
    best = _searched(lambda: sn.least_power_gait(*body, speed_m_s=wanted[0], **how))
    margins = interruptible(lambda: sn.gait_margins(*body, best.gait))
    best = replace(best, steady=warn_of_two_motions(best.steady))
    with working("servos") as show_share:
        moved = beside_servo(best.steady, kind, snake.fit is None, show_share)
    # what is sent is predicted when it is driven
    band = interruptible(lambda: None if send else predicted_band(snake, best.gait, kind))
    answer = _as_dict(best) | {"margins": margins.to_dict()} | speeds_as_dict(moved, band)
    answer |= snake.notes | servo_remark(kind)
    if not as_json:
        from ...show import report
        from ...show.gaits import gait_report

        gait_report.warn(best, moved)
        gait_report.warn_of_cliff(margins)
        words = f"{best.in_words()} {speed_in_words(best.steady, moved, band)}"
        parts = [best, *([moved] if moved else []), margins]
        report.show(*parts, answer=words, verbose=verbose)
    if send:
        from ...robot.robot_match import RobotMatch
        from ..board.driving import drive_gait

        cure = "give its links, or the session of this robot"
        match = RobotMatch(snake.robot.links, "the gait", cure)
        drive_gait(best.gait, as_json, snake.fit, match=match, before=answer, servo=kind, **run)
    elif as_json:
        show_json(answer)
    return None


def _limits(settings: Given, send: bool) -> sn.GaitLimits:
    """Return the limits of a search: those set, a new board's speed, and its angle for --send."""
    in_degrees = {"servo_speed_deg_s": _BOARD_SPEED_DEG_S}
    in_degrees |= {"joint_angle_deg": _BOARD_ANGLE_DEG} if send else {}
    in_degrees |= {s.name: settings[s.name] for s in LIMITS[:2] if s.name in settings}
    limits = {name.replace("_deg", "_rad"): math.radians(v) for name, v in in_degrees.items()}
    limits |= {s.name: settings[s.name] for s in LIMITS[2:] if s.name in settings}
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
    return answer | {"gait": describe(best.gait)} | best.steady.to_dict()


def _show_front(
    speeds: list[float], front: Sequence[sn.LeastPower | None], as_json: bool, notes: Given
) -> None:
    from ...show.gaits import gait_report

    if all(best is None for best in front):
        raise sn.NotConverged(
            f"no gait reaches {min(speeds):g} m/s within the limits; ask for less speed"
        )
    if as_json:
        found = [None if best is None else _as_dict(best) for best in front]
        show_json({"front": found} | notes)
    else:
        gait_report.front(speeds, front)
