"""The command `serpenoid simulate`: all of a Scene, by options, by a scene file, or by both."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import click

import serpenoid as sn

from ..base.checks import DRIVES, FORMULATIONS, GAPS, STARTS
from ..show.screen import progress, say, working
from ..simulation.methods import METHODS
from .declare import (
    FIGURES,
    Given,
    Options,
    PathType,
    angle,
    flag,
    number,
    option,
    out_file,
    refuse_typed,
)
from .options import (
    AS_TABLES,
    describe,
    gait_options,
    interruptible,
    make_gait,
    make_robot,
    robot_options,
    show_json,
)

_FILE = PathType(dir_okay=False)


def _pieces(text: str) -> list[str]:
    """Split at commas; `none` is nothing."""
    return [] if text.strip() in ("", "none") else [part.strip() for part in text.split(",")]


def _reader(read: Callable[[list[str]], Any], form: str) -> Callable[..., Any]:
    """Return a click callback that reads a list, or says which form it must have."""

    def callback(_ctx: click.Context, _param: click.Parameter, text: str | None) -> Any:
        try:
            return None if text is None else read(_pieces(text))
        except ValueError:
            raise click.BadParameter(f"{text!r} is not of the form {form}") from None

    return callback


def _pairs(parts: list[str]) -> list[tuple[str, float]]:
    halves = [part.split("=") for part in parts]
    return [(name.strip(), float(value)) for name, value in halves]


scene_options = Options(
    option(
        "--formulation",
        "Exact model (explicit, unless given), or the paper's springs.",
        choice=FORMULATIONS,
    ),
    number("--stiffness-n-m", "joint_stiffness_n_m", "Implicit: k of the joints; 1000."),
    number("--damping-n-s-m", "joint_damping_n_s_m", "Implicit: c of the joints; 1."),
    angle("--incline-deg", "Slope of the ground.", high=90.0),
    angle("--incline-direction-deg", "Uphill, from the x axis.", low=-360.0, high=360.0),
    option("--drive", "What moves the joints; angle.", choice=DRIVES),
    option(
        "--servo-fields",
        "servo",
        "Servos follow the gait: default ones, or stiffness_nm_rad=3,... (no kind).",
        metavar="[FIELD=VALUE,...]",
        is_flag=False,
        flag_value="none",
        callback=_reader(lambda parts: dict(_pairs(parts)), "FIELD=VALUE,..."),
    ),
    option(
        "--torque-nm",
        "Constant torque of every joint, in place of the gait.",
        metavar="T1,T2,...",
        callback=_reader(lambda parts: [float(part) for part in parts], "0.1,0.2"),
    ),
    option(
        "--limp",
        "Joints without torque; from 1, at the tail.",
        metavar="2,4",
        callback=_reader(lambda parts: tuple(int(part) for part in parts), "2,4"),
    ),
    option(
        "--locked-deg",
        "locked",
        "Joints that stay at an angle.",
        metavar="3=10,5=-20",
        callback=_reader(
            lambda parts: {int(n): math.radians(v) for n, v in _pairs(parts)}, "3=10,5=-20"
        ),
    ),
    option("--method", "nonsmooth on dry ground, else rk4, unless given.", choice=METHODS),
    number("--dt-s", "Time step; 0.001."),
    number("--tolerance", "Of methods that pick their steps; 1e-7."),
    number("--duration-s", "Length of the run; 10."),
    option("--start", "State at time 0; zero_momentum.", choice=STARTS),
    option("--gap", "Implicit: how the joints start open.", choice=GAPS),
    option(
        "--record",
        "What to keep beside the motion.",
        metavar="joints,friction,energy",
        callback=_reader(tuple, "energy"),
    ),
    option(
        "--record-every",
        "Time steps between records; 1, more where that is beyond 20 000 rows.",
        type=int,
    ),
)


@click.command()
@option("--scene", "scene_path", "Scene file; other options override it.", type=_FILE)
@option("--save-scene", "saved_path", "Write the scene to this file too.", type=out_file(".toml"))
@robot_options
@gait_options
@scene_options
@number(
    "--accuracy",
    "Pick what is not given of method and step for this error (body lengths, radians).",
)
@flag("--no-error", "Save the one or two runs that tell the error.")
@option("--out", "CSV of all links at all recorded times.", type=out_file(".csv"))
@option(
    "--plot",
    "figure",
    "PNG, PDF or SVG of path, speed and energy if recorded.",
    type=out_file(*FIGURES),
)
@AS_TABLES
def simulate(
    scene_path: Path | None,
    saved_path: Path | None,
    out: Path | None,
    figure: Path | None,
    accuracy: float | None,
    no_error: bool,
    as_json: bool,
    **given: Any,
) -> None:
    """Follow one scene in time: a scene file, options, or a file with options over it."""
    from ..show import report, run_report

    steps = ("dt_s", "tolerance") if accuracy is not None else ()
    keep = [name for name in steps if given[name] is not None]
    scene = make_scene(given, None if scene_path is None else sn.load_scene(scene_path))
    _check_that_all_apply(scene, accuracy)
    if saved_path is not None:
        sn.save_scene(scene, saved_path)
        report.wrote(saved_path)
    try:
        run = _watched(scene, accuracy, keep)
        if out is not None:
            run.to_csv(out)
    except KeyboardInterrupt:
        say("nothing of this run is kept", err=True)
        raise
    if out is not None:
        report.wrote(out)
    if figure is not None:
        from ..show.run_figure import draw_run

        draw_run(run, figure)
        report.wrote(figure)
    with working("estimating the error"):
        summary = interruptible(lambda: run_report.run_summary(run, not no_error))
    if as_json:
        show_json({"gait": describe(scene.gait)} | summary)
    else:
        run_report.show_run(run, summary)


def make_scene(given: Given, base: sn.Scene | None) -> sn.Scene:
    """Make a scene of the options that were given, over a scene file's if there is one."""
    robot, ground = make_robot(given, base and (base.robot, base.ground))
    # joints that are driven by torques need no gait: a straight chain at rest
    usual = base.gait if base else None if given["torque_nm"] is None else sn.Gait(0.0, 0.0, 1.0)
    gait = make_gait(given, usual)
    parts: Given = {"robot": robot, "ground": ground, "gait": gait}
    told = scene_options.take(given)
    parts |= _joint_drive(told, base)
    return replace(base, **parts | told) if base is not None else sn.Scene(**parts, **told)


def _check_that_all_apply(scene: sn.Scene, accuracy: float | None) -> None:
    """Raise UsageError for an option that the scene has no use for: it would change nothing."""
    pinned, springs = (
        scene.formulation == "explicit",
        "the joints are pinned; give --formulation implicit too",
    )
    steps = f"method {scene.method!r} takes fixed steps; give --dt-s, or a --method that picks them"
    for no_use, why, *names in (
        (pinned, springs, "joint_stiffness_n_m", "joint_damping_n_s_m", "gap"),
        (scene.incline_rad == 0, "the ground is level", "incline_direction_rad"),
        (not (scene.adaptive or accuracy), steps, "tolerance"),
    ):
        if no_use:
            refuse_typed(f"{{}} has no effect: {why}", *names)


def _joint_drive(told: Given, base: sn.Scene | None) -> Given:
    """Take the drive from the options: asking for servos or torques replaces the scene's own."""
    drive, servo, torque = (told.pop(name, None) for name in ("drive", "servo", "torque_nm"))
    asked = {"servo": servo, "torque": torque}
    drives = {name for name, value in asked.items() if value is not None} | {drive} - {None}
    if len(drives) > 1:
        raise click.UsageError(f"choose one drive; the options ask for {' and '.join(drives)}")
    if not drives:
        return {}
    (drive,) = drives
    if torque is None and base is not None:
        torque = base.torque
    return {
        "drive": drive,
        "servo": _servo(servo or {}, base and base.servo) if drive == "servo" else None,
        "torque": torque if drive == "torque" else None,
    }


def _servo(fields: dict[str, float], base: sn.Servo | None) -> sn.Servo:
    from ..base.toml_table import check_names

    check_names(fields, (), "--servo-fields", "field", tuple(sn.Servo.__slots__))
    return replace(base or sn.Servo(), **fields)


def _watched(scene: sn.Scene, accuracy: float | None, keep: list[str]) -> sn.Run:
    """Run a scene, telling on a terminal how far it is."""
    with progress(scene.duration_s, "s simulated", so_far=True) as tell:
        return interruptible(lambda: sn.simulate(scene, tell, accuracy=accuracy, keep=keep))
