"""The command `serpenoid steady`: the periodic state of one gait."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import click

import serpenoid as sn

from ..declare import Given, command, flag, refuse_unused, settings
from ..given import Snake, make_snake, take_servo
from ..options import (
    AS_TABLES,
    FRICTION,
    IDEAL,
    OFFSET,
    PINNED,
    PLUG,
    ROBOT,
    RTOL,
    SPRINGS,
    busy,
    describe,
    formulation_option,
    gait_options,
    make_gait,
    robot_option,
    servo_option,
    show_json,
    tell,
    warn_of_two_motions,
)

if TYPE_CHECKING:
    from ...prediction.band import SpeedBand

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
    from ...show import report
    from ...show.gaits import gait_report

    snake = make_snake(robot, settings)
    body = snake.robot, snake.ground, make_gait(typed_gait, settings)
    springs = {one.name: settings[one.name] for one in SPRINGS if one.name in settings}
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
    report.show(*expected.results, losses, answer=expected.in_words(), verbose=verbose)
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
    def results(self) -> list[sn.Steady | sn.ServoSteady]:
        """Return what has rows to print."""
        return [self.state, self.servo] if self.servo else [self.state]

    @property
    def best(self) -> SpeedBand | sn.ServoSteady | sn.Steady:
        """Return a fit's band, or else what servos leave of the speed."""
        if self.band is None or (self.servo and not self.servo.follows):
            return self.results[-1]
        return self.band

    def in_words(self) -> str:
        """Return what a builder may expect."""
        words = self.best.in_words()
        return f"Predicted: {words}." if self.best is self.band else words

    def to_dict(self) -> Given:
        """Return the speed with servos, and the band."""
        both = {"servo": self.servo, "band": self.band}
        return {name: part.to_dict() for name, part in both.items() if part is not None}


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
    from ...periodic.servo_steady import with_servo
    from ...prediction.band import speed_band

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
