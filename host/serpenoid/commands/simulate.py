"""The command `serpenoid simulate`: all of a Scene, by options, by a scene file, or by both."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import click

import serpenoid as sn

from ..base.checks import FORMULATIONS, GAPS, POSITIVE, STARTS, Limits
from ..base.errors import BadInput
from ..show.screen import progress, say, working
from ..simulation.methods import METHODS
from .declare import (
    FIGURES,
    Command,
    Given,
    Number,
    PathType,
    Setting,
    flag,
    number,
    option,
    out_file,
    parsed_number,
    settings,
)
from .given import Snake, make_snake, servo_remark, take_servo
from .options import (
    AS_TABLES,
    FRICTION,
    IDEAL,
    OFFSET,
    PLUG,
    ROBOT,
    SPRINGS,
    describe,
    gait_options,
    interruptible,
    make_gait,
    robot_option,
    servo_option,
    show_json,
)

_FILE = PathType(dir_okay=False)


def _pieces(text: str) -> list[str]:
    """Split at commas; `none` is nothing."""
    return [] if text.strip() in ("", "none") else [part.strip() for part in text.split(",")]


def _list(read: Callable[[str, list[str]], Any]) -> Callable[[str, str], Any]:
    """Return what reads a list with commas by `read`, which takes the setting's name, too."""
    return lambda name, text: read(name, _pieces(text))


def _numbers(name: str, parts: list[str]) -> list[float]:
    return [parsed_number(name, part) for part in parts]


def _joints(name: str, parts: list[str]) -> tuple[int, ...]:
    if not all(part.isdecimal() for part in parts):
        raise BadInput(f"{name} is {','.join(parts)!r}; give joints by number, such as 2,4")
    return tuple(map(int, parts))


def _locked(name: str, parts: list[str]) -> dict[int, float]:
    pairs = [part.partition("=") for part in parts]
    if not all(joint.isdecimal() and equals for joint, equals, _ in pairs):
        raise BadInput(f"{name} is {','.join(parts)!r}; give joints and angles: 3=10,5=-20")
    return {int(n): math.radians(parsed_number(f"{name} {n}", angle)) for n, _, angle in pairs}


# Fields of Scene; angles in degrees.
SCENE = (
    Setting("incline_direction_deg", "uphill, from the x axis", "deg", Limits(-360, 360), "0"),
    Setting(
        "torque_nm",
        "constant torque of each joint, in place of the gait: 0.1,0.2,...",
        "N m",
        read=_list(_numbers),
    ),
    Setting(
        "limp", "joints without torque, from 1 at the tail: 2,4", usual="none", read=_list(_joints)
    ),
    Setting(
        "locked_deg",
        "joints that stay at an angle: 3=10,5=-20",
        "deg",
        usual="none",
        read=_list(_locked),
    ),
    Setting("dt_s", "time step", "s", POSITIVE, "0.001"),
    Setting("tolerance", "of methods that pick their steps", "", POSITIVE, "1e-7"),
    Setting("start", "state at time 0", limits=STARTS, usual="zero_momentum"),
    Setting("gap", "implicit model: how the joints start open", limits=GAPS, usual=GAPS[0]),
    Setting(
        "record",
        "what to keep beside the motion: joints,friction,energy",
        usual="none",
        read=_list(lambda _name, parts: tuple(parts)),
    ),
    Setting(
        "record_every",
        "time steps between records",
        limits=Limits(1),
        usual="1, more beyond 20 000 rows",
        is_whole=True,
    ),
)


@click.command(cls=Command)
@option("--scene", "scene_path", "Scene file; other options override it.", type=_FILE)
@robot_option
@gait_options
@servo_option
@number("--incline-deg", "Slope of the ground, uphill along the x axis.", type=Number(0, 90))
@number("--duration-s", "Length of the run; 10.")
@option("--out", "CSV of all links at all recorded times.", type=out_file(".csv"))
@option(
    "--plot",
    "figure",
    "PNG, PDF or SVG of path, speed and energy if recorded.",
    type=out_file(*FIGURES),
)
@option("--save-scene", "saved_path", "Write the scene to this file too.", type=out_file(".toml"))
@settings(*ROBOT, *FRICTION, OFFSET, *PLUG, *SPRINGS, *SCENE)
@option(
    "--formulation",
    "Exact model (explicit, unless given), or the paper's springs.",
    choice=FORMULATIONS,
    research=True,
)
@option("--method", "nonsmooth on dry ground, else rk4.", choice=METHODS, research=True)
@number(
    "--accuracy",
    "Choose step, and method unless given, for this error (body lengths, radians).",
    research=True,
)
@flag("--no-error", "Save the runs that tell the error.", research=True)
@AS_TABLES
def simulate(
    scene_path: Path | None,
    saved_path: Path | None,
    out: Path | None,
    figure: Path | None,
    accuracy: float | None,
    no_error: bool,
    verbose: bool,
    as_json: bool,
    **given: Any,
) -> None:
    """Follow one scene in time: a scene file, options, or a file with options over it."""
    from ..show import report, run_report

    base = None if scene_path is None else sn.load_scene(scene_path)
    scene, notes = make_scene(base, **given)
    _check_that_all_apply(scene, accuracy, given["settings"])
    if saved_path is not None:
        sn.save_scene(scene, saved_path)
        report.wrote(saved_path)
    try:
        run = _watched(scene, accuracy)
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
        show_json({"gait": describe(scene.gait)} | summary | notes)
    else:
        run_report.show_run(run, summary, verbose)


def make_scene(
    base: sn.Scene | None,
    robot: str | None,
    servo: str | None,
    settings: Given,
    formulation: str | None,
    method: str | None,
    incline_deg: float | None,
    duration_s: float | None,
    **typed_gait: Any,
) -> tuple[sn.Scene, Given]:
    """Make a scene of the options, over a scene file's if there is one.

    Returns the scene, and what JSON says of the fit and the servo that it rests on.
    """
    snake = make_snake(robot, settings, base and Snake(base.robot, base.ground))
    # joints that are driven by torques need no gait: a straight chain at rest
    torques = "torque_nm" in settings
    usual = base.gait if base else sn.Gait(0.0, 0.0, 1.0) if torques else None
    fields: Given = {"robot": snake.robot, "ground": snake.ground}
    fields["gait"] = make_gait(typed_gait, settings, usual)
    own = {"torque_nm", "incline_direction_deg", "locked_deg"}  # under other names in a Scene
    known = {one.name for one in (*SCENE, *SPRINGS)} - own
    fields |= {name: settings[name] for name in known if name in settings}
    if "locked_deg" in settings:
        fields["locked"] = settings["locked_deg"]
    directions = {"incline_deg": incline_deg, **settings}
    for name in ("incline_deg", "incline_direction_deg"):
        if directions.get(name) is not None:
            fields[name.replace("_deg", "_rad")] = math.radians(directions[name])
    options = {"formulation": formulation, "method": method, "duration_s": duration_s}
    fields |= {name: value for name, value in options.items() if value is not None}

    kind = take_servo(servo, settings, IDEAL, snake)
    if servo is not None:
        if torques:
            raise click.UsageError("give one of --servo and --set torque_nm: both drive the joints")
        drive = "angle" if kind is None else "servo"
        fields |= {"drive": drive, "servo": kind and kind.servo, "torque": None}
    if torques:
        fields |= {"drive": "torque", "torque": settings["torque_nm"], "servo": None}
    scene = sn.Scene(**fields) if base is None else replace(base, **fields)
    return scene, snake.notes | servo_remark(kind)


def _check_that_all_apply(scene: sn.Scene, accuracy: float | None, settings: Given) -> None:
    """Raise BadInput for a setting that the scene has no use for: it would change nothing."""
    springs = "the joints are pinned; give --formulation implicit too"
    chosen = "--accuracy chooses it"
    steps = f"method {scene.method!r} takes fixed steps; give dt_s, or a --method that picks them"
    pinned = scene.formulation == "explicit"
    for no_use, why, *names in (
        (pinned, springs, "joint_stiffness_n_m", "joint_damping_n_s_m", "gap"),
        (scene.incline_rad == 0, "the ground is level", "incline_direction_deg"),
        (accuracy is not None, chosen, "tolerance"),
        (not scene.adaptive, steps, "tolerance"),
    ):
        for name in names:
            if no_use and name in settings:
                raise BadInput(f"{name} has no effect: {why}")


def _watched(scene: sn.Scene, accuracy: float | None) -> sn.Run:
    """Run a scene, telling on a terminal how far it is."""
    with progress(scene.duration_s, "s simulated", so_far=True) as tell:
        return interruptible(lambda: sn.simulate(scene, tell, accuracy=accuracy))
