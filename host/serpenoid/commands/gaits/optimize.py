"""The command `serpenoid optimize`: the gait of least power at a speed, onto the robot if asked."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, TypeVar

import click

import serpenoid as sn

from ...base.checks import check_number
from ...show.screen import working
from ..declare import (
    Given,
    Options,
    Range,
    angle,
    flag,
    number,
    option,
    out_file,
    refuse_typed,
)
from ..given import (
    is_of_fit,
    predicted_band,
    servo_as_filmed,
    take_fit,
)
from ..options import (
    AS_TABLES,
    GROUND,
    IDEAL,
    ROBOT,
    describe,
    formulation_option,
    interruptible,
    make_robot,
    robot_options,
    servo_option,
    show_json,
    take_servo,
    typed,
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
LIMITS = Options(  # of GaitLimits
    angle(
        "--joint-angle-deg", "Most a joint may bend; 110 unless given.", high=180.0, open_low=True
    ),
    angle(
        "--servo-speed-deg-s",
        "Most a servo turns; 500, a new board's limit, unless given; inf: no limit.",
        low=1e-3,
        high=math.inf,
    ),
    number("--servo-torque-nm", "Most a servo holds."),
    number("--omega-low-rad-s", "Lowest rate of the gait."),
    number("--omega-high-rad-s", "Highest rate of the gait."),
)
RUN = Options(  # of drive_gait
    option("--port", "Serial port; found by its USB id unless given."),
    option(
        "--duration-s",
        "With --send: how long; until Ctrl-C unless given.",
        type=Range(0, min_open=True),
    ),
    option("--record", "With --send: new file for the run's lines.", type=out_file()),
)


@click.command()
@robot_options
@option(
    "--speed-m-s",
    "--speed",
    "speed_m_s",
    "Wanted speed; several, with commas, give the whole front.",
    required=True,
    metavar="M/S[,M/S...]",
)
@option(
    "--cost",
    "Mean power to make least.",
    choice=["power", "abs_power", "positive_power"],
    default="power",
)
@formulation_option
@LIMITS
@servo_option
@flag("--send", "Drive the gait on the robot, as `drive` does.")
@RUN
@AS_TABLES
def optimize(speed_m_s: str, as_json: bool, send: bool, **given: Any) -> None:
    """Find the gait that costs least power at a speed, and say how near to a cliff it stands.

    Gaits are searched with ideal joints. Beside the speed stands what servos leave of it: any hobby
    servo unless --servo says which, or `ideal`.

    With --session DIR or --ground FILE the friction is a fit's.
    """
    wanted = _speeds(speed_m_s)
    if not send:
        words = "{} is for --send, which is not there"
        refuse_typed(words, *RUN.names)
    run = RUN.take(given)
    if len(wanted) > 1 and (send or typed("servo")):
        raise click.UsageError("--send and --servo take one speed")
    if send:  # board and the recording's place are found before the search, not after it
        from ...robot.recording.recorder import check_free
        from ...robot.wire.ports import find_port

        if "record" in run:
            check_free(run["record"])
        if "port" not in run:
            find_port()
    ask = _Asked(given, send)
    if len(wanted) > 1:
        return _show_front(ask, wanted, as_json)
    best = _searched(lambda: ask.find(wanted[0]))

    margins = interruptible(lambda: sn.gait_margins(ask.robot, ask.ground, best.gait))
    best = replace(best, steady=warn_of_two_motions(best.steady))
    fit = None if send else ask.fit  # what is sent is predicted when it is driven
    with_band = not is_of_fit(fit, ask.robot, ask.ground)
    with working("servos") as show_share:
        moved = beside_servo(best.steady, ask.shown_servo, with_band, show_share)
    band = interruptible(lambda: predicted_band(fit, ask.robot, ask.ground, best.gait, ask.servo))
    answer = _as_dict(best) | {"margins": margins.to_dict()} | speeds_as_dict(moved, band)
    if not as_json:
        from ...show import report
        from ...show.gaits import gait_report

        words = f"{best.in_words()} {speed_in_words(best.steady, moved, band)}"
        report.show(best, *([moved] if moved else []), margins, answer=words)
        gait_report.warn(best, moved)
        gait_report.warn_of_cliff(margins)
    if send:
        _send(ask, best.gait, as_json, answer, **run)
    elif as_json:
        show_json(answer)
    return None


def _send(ask: _Asked, gait: sn.Gait, as_json: bool, before: Given, **run: Any) -> None:
    """Drive the gait, its robot checked against the board."""
    from ...robot.robot_match import RobotMatch
    from ..board.driving import drive_gait

    cure = "give its --links, or the session of this robot"
    match = RobotMatch(ask.robot.links, "the gait", cure)
    drive_gait(
        gait, as_json=as_json, fit=ask.fit, match=match, before=before, servo=ask.servo, **run
    )


def _speeds(text: str) -> list[float]:
    try:
        speeds = [float(part) for part in text.split(",")]
    except ValueError:
        raise click.BadParameter(
            f"{text!r} is not a speed, nor speeds with commas", param_hint="--speed-m-s"
        ) from None
    return [check_number("--speed-m-s", speed, 0.0, open_low=True) for speed in speeds]


class _Asked:
    """What the options ask for: robot, ground, servo, and how to search."""

    def __init__(self, given: Given, send: bool) -> None:
        cost, formulation = given.pop("cost"), given.pop("formulation")
        # a new board's speed unless given, and its angle if the gait is sent
        board = {"servo_speed_rad_s": math.radians(_BOARD_SPEED_DEG_S)}
        board |= {"joint_angle_rad": math.radians(_BOARD_ANGLE_DEG)} if send else {}
        self._how = {"cost": cost, "limits": sn.GaitLimits(**board | LIMITS.take(given))}
        fit = take_fit(given)
        changed = [
            p.opts[0]
            for p in click.get_current_context().command.params
            if p.name in (*ROBOT.names, *GROUND.names) and given[p.name] is not None
        ]
        self.fit = None if changed else fit
        ideal = self.fit is None
        self.servo = servo_as_filmed(take_servo(IDEAL if ideal else "hobby"), self.fit)
        self.robot, self.ground = make_robot(given, fit=fit)
        shown = typed("servo") is None and few_links(self.robot)
        self.shown_servo = take_servo("hobby") if shown and self.servo is None else self.servo
        self._how["formulation"] = formulation

    def find(self, speed: float) -> sn.LeastPower:
        """Search for one speed."""
        return sn.least_power_gait(self.robot, self.ground, speed_m_s=speed, **self._how)

    def front(self, speeds: list[float]) -> Sequence[sn.LeastPower | None]:
        """Search for many speeds; None for one that no gait reaches."""
        return _searched(
            lambda: sn.power_front(self.robot, self.ground, speeds_m_s=speeds, **self._how)
        )


def _searched(work: Callable[[], _Result]) -> _Result:
    """Return work() and show that it goes on; Ctrl-C ends both, so this thread shows it."""
    with working("searching"):
        return interruptible(work)


def _as_dict(best: sn.LeastPower) -> Given:
    answer = {name: getattr(best, _KEYS.get(name, name)) for name in _OF_LEAST_POWER}
    return answer | {"gait": describe(best.gait)} | best.steady.to_dict()


def _show_front(ask: _Asked, speeds: list[float], as_json: bool) -> None:
    from ...show.gaits import gait_report

    front = ask.front(speeds)
    if all(best is None for best in front):
        raise sn.NotConverged(
            f"no gait reaches {min(speeds):g} m/s within the limits; ask for less speed"
        )
    if as_json:
        show_json({"front": [None if best is None else _as_dict(best) for best in front]})
    else:
        gait_report.front(speeds, front)
