"""The command `serpenoid optimize`: the gait of least power at a speed."""

from __future__ import annotations

import math
from contextlib import suppress
from dataclasses import replace

import serpenoid as sn

from ...base.checks import NOT_NEGATIVE, POSITIVE, Limits
from ...show.screen import say
from ..declare import Given, Setting, command, flag, number, settings
from ..given import make_snake, take_servo
from ..options import (
    AS_TABLES,
    FRICTION,
    IDEAL,
    PLUG,
    ROBOT,
    busy,
    describe,
    formulation_option,
    robot_option,
    servo_option,
    show_json,
    warn_of_two_motions,
)
from .steady import expect, few_links

_BOARD_ANGLE_DEG, _BOARD_SPEED_DEG_S = 90.0, 500.0  # a new board's own limits
_KEPT_SPEED_SHARE = 0.8  # with 10 % less amplitude, and with 20 % less friction across
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
    settings: Given,
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
    from ...show import report
    from ...show.gaits import gait_report

    snake = make_snake(robot, settings)
    body = snake.robot, snake.ground
    usual = "hobby" if few_links(snake) or not ideal else IDEAL
    kind = take_servo(servo or usual, settings, snake)
    wanted: Given = {"speed_m_s": speed_m_s, "formulation": formulation}
    wanted["cost"] = settings.get("cost", "power")

    def searched(_: object) -> tuple[sn.LeastPower, sn.LeastPower | None]:
        best = sn.least_power_gait(*body, limits=_limits(settings, ideal, kind), **wanted)
        with suppress(sn.NotConverged):
            return best, None if ideal else sn.least_power_gait(*body, **wanted)
        return best, None

    best, paper = busy("searching", searched)
    best = replace(best, steady=warn_of_two_motions(best.steady))
    shown = kind if servo or few_links(snake) else None
    expected = busy("servos", lambda share: expect(snake, best.steady, shown, share))
    if as_json:
        kept = {"gait", "cost_w", "losses"}
        ideal_values = paper and {k: v for k, v in _as_dict(paper).items() if k in kept}
        values = _as_dict(best) | best.steady.to_dict() | {"ideal": ideal_values}
        return show_json(values | expected.to_dict() | snake.notes)
    gait_report.warn_of_losses(best.losses)
    words = f"{best.in_words()} {expected.in_words()}"
    if paper is None:
        gait_report.warn_too_fast(best.gait, kind or sn.servo("hobby"))
    else:
        words += f" {gait_report.beside_ideal(best, paper, kind)}"
    report.show(best, *expected.results[1:], answer=words, verbose=verbose)
    typed = [f"--{k.replace('_', '-')} {v:.4g}" for k, v in describe(best.gait).items() if v]
    named = [f"--robot {robot}"] if robot else []
    say(f"drive it: serpenoid drive {' '.join(named + typed)}")
    return None


def _limits(settings: Given, ideal: bool, kind: sn.ServoKind | None) -> sn.GaitLimits:
    """Return the limits of a search: those set, else the robot's unless ideal.

    The robot's are those of a new board, of servos that are to follow, and of the speed that is to
    be kept.
    """
    from ...servos.speed_limit import MAX_NO_LOAD_SHARE, no_load_rad_s

    limits: Given = {}
    if not ideal:
        limits["joint_angle_rad"] = math.radians(_BOARD_ANGLE_DEG)
        limits["servo_speed_rad_s"] = math.radians(_BOARD_SPEED_DEG_S)
        limits["kept_speed_share"] = _KEPT_SPEED_SHARE
        if kind is not None:
            followed_rad_s = (1 - _SPEED_ROUNDING) * MAX_NO_LOAD_SHARE * no_load_rad_s(kind)
            limits["servo_speed_rad_s"] = min(limits["servo_speed_rad_s"], followed_rad_s)
    for name in {one.name for one in LIMITS} & settings.keys():
        value, field = settings[name], name.replace("_deg", "_rad")
        limits[field] = value if field == name else math.radians(value)
    return sn.GaitLimits(**limits)


def _as_dict(best: sn.LeastPower) -> Given:
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
