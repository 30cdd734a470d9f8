"""The command `serpenoid steady`: the periodic state of one gait."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import click

import serpenoid as sn

from ...show.screen import working
from ..declare import Command, Given, flag, settings
from ..given import (
    JOINTS,
    Snake,
    make_snake,
    predicted_band,
    servo_remark,
    take_servo,
    was_filmed,
    with_joints,
)
from ..options import (
    AS_TABLES,
    FRICTION,
    IDEAL,
    OFFSET,
    PLUG,
    ROBOT,
    RTOL,
    SPRINGS,
    describe,
    formulation_option,
    gait_options,
    interruptible,
    make_gait,
    robot_option,
    servo_option,
    show_json,
    warn_of_two_motions,
)

if TYPE_CHECKING:
    from ...prediction.band import SpeedBand


_FEW_LINKS = 20


@click.command(cls=Command)
@robot_option
@gait_options
@servo_option
@settings(*ROBOT, *FRICTION, OFFSET, *PLUG, *SPRINGS, RTOL, JOINTS)
@formulation_option
@flag(
    "--sensitivities",
    "differentiated",
    "What 1 % of each parameter changes (ideal joints); with a fit, what each unknown leaves.",
    research=True,
)
@AS_TABLES
def steady(
    robot: str | None,
    servo: str | None,
    settings: Given,
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
    snake = make_snake(robot, settings)
    joints = settings.get("joints")
    command = make_gait(typed_gait, settings)
    gait = with_joints(command, joints, snake.robot.links)
    springs = {one.name: settings[one.name] for one in SPRINGS if one.name in settings}
    rtol = settings.get("rtol", 1e-6)
    if formulation == "implicit":
        if servo not in (None, IDEAL) or "volts" in settings or "frame_ms" in settings:
            raise click.UsageError(
                "--servo, volts and frame_ms have no effect on --formulation implicit"
            )
        if differentiated:
            raise click.UsageError(
                "--sensitivities are those of the exact model; leave --formulation implicit out"
            )
        return _on_springs(snake, gait, verbose, as_json, rtol=rtol, **springs)
    if springs:
        raise click.UsageError(
            f"{' and '.join(springs)} have no effect: the joints are pinned; give "
            "--formulation implicit too"
        )
    # a film shows what servos make of the joints
    usual = "hobby" if joints is None and few_links(snake.robot) else IDEAL
    kind = take_servo(servo, settings, usual, snake)
    commanded = command if joints and was_filmed(command, joints, snake.robot.links) else None
    with working("solving") as show_share:
        state = interruptible(
            lambda: sn.steady_gait(
                snake.robot, snake.ground, gait, rtol=rtol, sensitivities=differentiated
            )
        )
        moved = beside_servo(state, kind, snake.fit is None, show_share)
        losses = interruptible(lambda: sn.speed_losses(snake.robot, snake.ground, gait))
        band = interruptible(lambda: predicted_band(snake, gait, kind, commanded))
    state = warn_of_two_motions(state)
    if doubt := state.power_doubt_text(rtol):
        warnings.warn(doubt, stacklevel=2)
    if as_json:
        known = {"losses": losses.to_dict()}
        values = {"gait": describe(gait)} | state.to_dict() | known | snake.notes
        return show_json(values | speeds_as_dict(moved, band) | servo_remark(kind))
    from ...show import report
    from ...show.gaits import gait_report

    gait_report.warn_of_losses(losses)
    answer = speed_in_words(state, moved, band)
    report.show(state, *([moved] if moved else []), losses, answer=answer, verbose=verbose)
    if state.sensitivities is not None:
        report.show(state.sensitivities, verbose=verbose)
    return None


def _on_springs(
    snake: Snake, gait: sn.Gait, verbose: bool, as_json: bool, rtol: float, **springs: float
) -> None:
    """Tell the periodic state of the implicit model."""
    from ...show import report

    body = snake.robot, snake.ground, gait
    with working("solving"):
        soft = interruptible(lambda: sn.steady_springs(*body, rtol=rtol, **springs))
    if soft.error_estimate > rtol:
        warnings.warn(
            f"the speed is known to {soft.error_estimate:.1g}, not to the rtol of {rtol:g}: the "
            "time steps of the springs do not give more",
            stacklevel=2,
        )
    if as_json:
        return show_json({"gait": describe(gait)} | soft.to_dict() | snake.notes)
    return report.show(soft, verbose=verbose)


def few_links(robot: sn.Robot) -> bool:
    """Tell whether servos are asked about unasked: the work grows as the cube of the links."""
    return robot.links <= _FEW_LINKS


def speeds_as_dict(moved: sn.ServoSteady | None, band: SpeedBand | None) -> Given:
    """Return the speed with servos, and a fit's band; that is then the only interval of the speed.

    The band has no ends where the servos cannot follow the gait.
    """
    no_ends = {"low_m_s": None, "high_m_s": None}
    answer: Given = {"servo": moved.to_dict()} if moved else {}
    if band is not None:
        answer["band"] = band.to_dict() | (no_ends if moved and not moved.follows else {})
    return answer


def speed_in_words(state: sn.Steady, moved: sn.ServoSteady | None, band: SpeedBand | None) -> str:
    """Return what a builder may expect: a fit's band, or else what servos leave of the speed."""
    if band is None or (moved and not moved.follows):
        return (moved or state).in_words()
    return f"Predicted: {band.in_words()}."


def beside_servo(
    ideal: sn.Steady,
    servo: sn.ServoKind | None,
    with_band: bool,
    show_share: Callable[[float], object] | None,
) -> sn.ServoSteady | None:
    """Return the speed with servos; one that does not settle is named, and is no reason to stop.

    with_band: solve the servos drawn from the kind, too, for the interval that they leave.
    show_share: called with the share of the work that is done.
    """
    from ...periodic.servo_steady import DRAWS, with_servo

    if servo is None:
        return None
    draws = DRAWS if with_band else 0
    try:
        return interruptible(lambda: with_servo(ideal, servo, draws, show_share))
    except sn.NotConverged as error:
        warnings.warn(str(error), stacklevel=2)
        return error.best
