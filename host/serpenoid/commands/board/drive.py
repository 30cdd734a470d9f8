"""`serpenoid drive`: a gait, watched and recorded."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ...show.screen import say
from ..declare import flag, option
from ..given import servo_as_filmed, take_fit
from ..options import (
    AS_JSON,
    describe,
    fit_options,
    gait_options,
    interruptible,
    make_gait,
    preset_robot,
    servo_option,
    show_json,
    take_servo,
)
from ..paths import out_file
from .port import PORT

if TYPE_CHECKING:
    from ...calibration.friction_result import FrictionFit
    from ...calibration.speed_samples import SpeedBand
    from ...model.drives import ServoKind
    from ...model.gait import Gait
    from ...robot.robot_match import RobotMatch
    from ...robot.tools.driven_run import DrivenRun
    from ...show.live import View


@click.command()
@gait_options
@fit_options
@servo_option
@option(
    "--duration-s", "How long; until Ctrl-C unless given.", type=click.FloatRange(0, min_open=True)
)
@PORT
@option("--record", "New file for every line of the run.", type=out_file())
@flag(
    "--page",
    "Show the robot live on a page of this machine's browser: where the model goes "
    "with the joints as reported, for the 2005 robot and ground without a fit.",
)
@AS_JSON
def drive(
    duration_s: float | None,
    port: str | None,
    record: Path | None,
    page: bool,
    as_json: bool,
    **given: Any,
) -> None:
    """Drive a gait and watch it; Ctrl-C stops the robot first. Lay it straight before.

    With --session DIR or --ground FILE the speed that the fitted friction predicts stands beside,
    with any hobby servo unless --servo says which.

    Exit status 0 at the end of --duration-s, or at Ctrl-C where none was given; 130 at an earlier
    Ctrl-C, or Stop on the page.
    """
    session = given.get("session")
    fit = take_fit(given)
    servo = servo_as_filmed(take_servo("hobby"), session, fit)
    gait, run = make_gait(given), {"duration_s": duration_s, "port": port, "record": record}
    drive_gait(gait, as_json, fit, page=page, servo=servo, **run)


def drive_gait(
    gait: Gait,
    as_json: bool,
    fit: FrictionFit | None = None,
    *,
    duration_s: float | None = None,
    port: str | None = None,
    record: Path | None = None,
    match: RobotMatch | None = None,
    page: bool = False,
    before: dict[str, Any] | None = None,
    servo: ServoKind | None = None,
) -> None:
    """Drive a gait, show it, and sum it up, as the command `drive` says.

    fit: of this robot's friction, if there is one; servo: what moves its joints; match: the robot
    that the gait is for, that of the fit unless given. A board of other joints is refused. before:
    what a command that drives afterwards has found; with as_json all is one document, the run under
    "drive".
    """
    from ...robot.tools.driven_run import DrivenRun
    from ...show.live import view

    band = None if fit is None else _predicted(fit, gait, as_json, servo)
    run = DrivenRun(gait, port, record, match or _match(fit))
    try:
        with ExitStack() as stack:
            shows = [_page(stack, run, fit, as_json)] if page else []
            if not as_json:
                shows.append(stack.enter_context(view(band)))
            interrupted = _watch(run, duration_s, shows)
    finally:  # a run that failed has a summary too
        _sum_up(run, as_json, band, before, servo)
    if interrupted and duration_s is not None:
        raise SystemExit(130)


def _match(fit: FrictionFit | None) -> RobotMatch | None:
    from ...robot.robot_match import RobotMatch

    if fit is None:
        return None
    return RobotMatch(fit.robot.links, "the friction", "give the session of this robot, or none")


def _predicted(fit: FrictionFit, gait: Gait, quiet: bool, servo: ServoKind | None) -> SpeedBand:
    """Return the speed to expect, told before anything moves."""
    from ...calibration.speed_samples import speed_band

    band = interruptible(lambda: speed_band(fit, gait, servo=servo))
    if not quiet:
        say(f"predicted: {band.in_words()}")
    return band


def _watch(run: DrivenRun, duration_s: float | None, shows: list[View]) -> bool:
    """Drive; return whether Ctrl-C or the page ended it."""

    def show(now: DrivenRun) -> None:
        for one in shows:
            one(now)

    try:
        run.run(duration_s, show)
    except KeyboardInterrupt:
        if run.last is None:
            raise
        return True
    return run.halted


def _page(stack: ExitStack, run: DrivenRun, fit: FrictionFit | None, quiet: bool) -> View:
    """Serve the page, say its address, and return what brings it up to date."""
    from ...robot.robot_match import RobotMatch
    from ...show.pages.live_page import LivePage

    robot, ground = preset_robot("2005") if fit is None else (fit.robot, fit.ground)
    whose = "2005 robot and ground" if fit is None else "robot and ground of the session"
    cure = "give the session of this robot, or leave --page out"
    run.match = run.match or RobotMatch(robot.links, f"the page's twin, {whose},", cure)
    page = stack.enter_context(LivePage(run, robot, ground, whose))
    say(f"page: {page.url}", err=quiet)
    return page.show


def _sum_up(
    run: DrivenRun,
    as_json: bool,
    band: SpeedBand | None,
    before: dict[str, Any] | None,
    servo: ServoKind | None,
) -> None:
    """Sum up a run; note where the board's frames are not those that the prediction has."""
    from ...show.live import show_summary

    found = run.summary()
    if found is None:
        return show_json(before) if as_json and before is not None else None
    frame_ms = run.robot.hello.frame_us / 1e3
    if band and servo and frame_ms != round(1e3 * servo.servo.frame_s, 3):
        say(
            f"note: this board sets its servos every {frame_ms:g} ms, and the prediction is for "
            f"{1e3 * servo.servo.frame_s:g} ms: give --frame-ms {frame_ms:g}",
            err=True,
        )
    if not as_json:
        return show_summary(found, band)
    told = {} if band is None else {"predicted": band.to_dict()}
    told = {"gait": describe(run.gait), "frame_ms": frame_ms} | told | vars(found)
    return show_json(told if before is None else before | {"drive": told})
