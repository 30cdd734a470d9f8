"""The command `serpenoid steady`: the periodic state of one gait."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

import serpenoid as sn

from ...show.screen import working
from ..declare import Given, Options, flag, number
from ..given import (
    is_of_fit,
    joints_option,
    predicted_band,
    servo_as_filmed,
    take_fit,
    was_filmed,
    with_joints,
)
from ..options import (
    AS_TABLES,
    IDEAL,
    describe,
    formulation_option,
    gait_options,
    interruptible,
    make_gait,
    make_robot,
    robot_options,
    servo_option,
    show_json,
    take_servo,
    typed,
    warn_of_two_motions,
)

if TYPE_CHECKING:
    from ...prediction.speed_samples import SpeedBand


_FEW_LINKS = 20


_SPRINGS = Options(
    number("--stiffness-n-m", "joint_stiffness_n_m", "Implicit: k; 1000 unless given."),
    number("--damping-n-s-m", "joint_damping_n_s_m", "Implicit: c; 1 unless given."),
)


@click.command()
@robot_options
@gait_options
@number("--rtol", "Relative accuracy.", default=1e-6)
@formulation_option
@_SPRINGS
@servo_option
@joints_option
@flag(
    "--sensitivities",
    "differentiated",
    "What 1 % of each parameter changes (ideal joints); with a fit, what each unknown leaves.",
)
@AS_TABLES
def steady(
    as_json: bool,
    differentiated: bool,
    joints: Path | None,
    rtol: float,
    formulation: str,
    **given: Any,
) -> None:
    """Find the periodic state of one gait: speed, powers, settling time, margins.

    The figures are those of joints that follow the gait exactly. Beside them stands the speed with
    servos: with any hobby servo unless --servo says which, or `ideal`.
    """
    springs = _SPRINGS.take(given)
    fit = take_fit(given)
    robot, ground = make_robot(given, fit=fit)
    told = make_gait(given)
    gait = with_joints(told, joints, robot.links)
    if formulation == "implicit":
        body = robot, ground, gait
        return _on_springs(*body, as_json, differentiated, rtol=rtol, **springs)
    if springs:
        raise click.UsageError(
            "--stiffness-n-m and --damping-n-s-m have no effect: the joints are pinned; give "
            "--formulation implicit too"
        )
    # a film shows what servos make of the joints
    usual = "hobby" if joints is None and few_links(robot) else IDEAL
    servo = servo_as_filmed(take_servo(usual), fit)
    commanded = told if joints and was_filmed(told, joints, robot.links) else None
    with working("solving") as show_share:
        state = interruptible(
            lambda: sn.steady_gait(robot, ground, gait, rtol=rtol, sensitivities=differentiated)
        )
        with_band = not is_of_fit(fit, robot, ground)
        moved = beside_servo(state, servo, with_band, show_share)
        margins = interruptible(lambda: sn.gait_margins(robot, ground, gait))
        band = interruptible(lambda: predicted_band(fit, robot, ground, gait, servo, commanded))
        doubts, sigmas = None, {}
        if fit and band:
            from ...prediction.speed_doubts import margin_sigmas, speed_doubts

            sigmas = margins.in_sigmas(*margin_sigmas(fit, band.filmed))
            if state.sensitivities is not None and state.sensitivities.at[0] > 0:
                doubts = speed_doubts(fit, gait, state.sensitivities, band)
    state = warn_of_two_motions(state)
    if doubt := state.power_doubt_text(rtol):
        warnings.warn(doubt, stacklevel=2)
    if as_json:
        known = {"margins": margins.to_dict() | sigmas}
        known |= {"doubts": doubts.to_dict()} if doubts else {}
        values = {"gait": describe(gait)} | state.to_dict() | known
        return show_json(values | speeds_as_dict(moved, band))
    from ...show import report
    from ...show.gaits import gait_report

    answer = speed_in_words(state, moved, band)
    report.show(state, *([moved] if moved else []), margins, answer=answer)
    if state.sensitivities is not None:
        report.show(state.sensitivities)
    if doubts is not None:
        gait_report.doubts(doubts)
    return gait_report.warn_of_cliff(margins, sigmas)


def _on_springs(
    robot: sn.Robot,
    ground: sn.Ground,
    gait: sn.Gait,
    as_json: bool,
    differentiated: bool,
    rtol: float,
    **springs: float,
) -> None:
    """Tell the periodic state of the implicit model; refuse what only the exact one has."""
    from ...show import report

    if typed("servo") not in (None, IDEAL) or typed("volts") or typed("frame_ms"):
        raise click.UsageError(
            "--servo, --volts and --frame-ms have no effect on --formulation implicit"
        )
    if differentiated:
        raise click.UsageError(
            "--sensitivities are those of the exact model; leave --formulation implicit out"
        )

    with working("solving"):
        soft = interruptible(lambda: sn.steady_springs(robot, ground, gait, rtol=rtol, **springs))
    if soft.error_estimate > rtol:
        warnings.warn(
            f"the speed is known to {soft.error_estimate:.1g}, not to the --rtol of {rtol:g}: the "
            "time steps of the springs do not give more",
            stacklevel=2,
        )
    if as_json:
        return show_json({"gait": describe(gait)} | soft.to_dict())
    return report.show(soft)


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
    """Return the speed with servos; what does not settle is told, and is no reason to stop.

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
