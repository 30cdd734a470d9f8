"""The commands on runs in time: simulate, view a scene or a recording, copy examples."""

from __future__ import annotations

import math
import shutil
from collections.abc import Callable
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import click

import serpenoid as sn

from .. import _core
from ..base.checks import GAPS, STARTS, Limits
from ..show.screen import say
from .declare import (
    EXISTING,
    FOLDER,
    OutFile,
    Setting,
    Values,
    command,
    flag,
    number,
    option,
    parsed_number,
    plain_text,
    refuse_unused,
    settings,
)
from .options import (
    FRICTION,
    IDEAL,
    OFFSET,
    PINNED,
    PLUG,
    ROBOT,
    SPRINGS,
    Snake,
    busy,
    describe,
    make_gait,
    make_snake,
    show_json,
    take_servo,
)


def _list(read: Callable[[str, str], Any]) -> Callable[[str, str], list[Any]]:
    """Return what reads a list with commas, each part by `read`; `none` is an empty one."""
    return lambda name, text: [] if text == "none" else [read(name, x) for x in text.split(",")]


METHODS = tuple(row["name"] for row in _core.method_table())
ANGLES = {"incline_deg", "incline_direction_deg"}
# Fields of Scene, angles in degrees. Joint torques and locked joints are for scene files.
SCENE = (
    Setting("incline_direction_deg", "uphill, from the x axis", "deg", Limits(-360, 360), "0"),
    Setting("limp", "joints without torque, from 1 at the tail: 2,4", read=_list(parsed_number)),
    Setting("dt_s", "time step", "s", usual="0.001"),
    Setting("tolerance", "of methods that pick their steps", usual="1e-7"),
    Setting(
        "start", f"state at time 0: {', '.join(STARTS)}", usual="zero_momentum", read=plain_text
    ),
    Setting(
        "gap",
        f"implicit model: how the joints start open: {', '.join(GAPS)}",
        usual=GAPS[0],
        read=plain_text,
    ),
    Setting(
        "record", "what to keep beside the motion: joints,friction,energy", read=_list(plain_text)
    ),
    Setting(
        "record_every",
        "time steps between records",
        usual="1, more beyond 20 000 rows",
    ),
)


@command()
@option(
    "--scene",
    "scene_path",
    "Scene file; other options override it.",
    type=click.Path(dir_okay=False, path_type=Path),
)
@option(
    "--incline-deg", "Slope of the ground, uphill along the x axis.", type=click.FloatRange(0, 90)
)
@number("--duration-s", "Length of the run; 10.")
@option("--out", "csv", "CSV of all links at all recorded times.", type=OutFile(".csv"))
@option("--save-scene", "saved_path", "Write the scene to this file too.", type=OutFile(".toml"))
@settings(*ROBOT, *FRICTION, OFFSET, *PLUG, *SPRINGS, *SCENE)
@option("--method", "nonsmooth on dry ground, else rk4.", choice=METHODS, research=True)
@number(
    "--accuracy",
    "Choose step, and method unless given, for this error (body lengths, radians).",
    research=True,
)
@flag("--no-error", "Save the runs that tell the error.", research=True)
def simulate(
    robot: str | None,
    servo: str | None,
    settings: Values,
    formulation: str | None,
    scene_path: Path | None,
    saved_path: Path | None,
    csv: Path | None,
    figure: Path | None,
    accuracy: float | None,
    no_error: bool,
    verbose: bool,
    as_json: bool,
    **typed_gait: Any,
) -> None:
    """Follow one scene in time: a scene file, options, or a file with options over it."""
    from ..show import report, run_report

    base = scene_path and sn.load_scene(scene_path)
    snake = make_snake(robot, settings, base and Snake(base.robot, base.ground))
    values = settings | typed_gait | {"formulation": formulation}
    scene = make_scene(base, snake, servo, {n: v for n, v in values.items() if v is not None})
    if scene.formulation == "explicit":
        refuse_unused(settings, PINNED, "joint_stiffness_n_m", "joint_damping_n_s_m", "gap")
    if saved_path is not None:
        sn.save_scene(scene, saved_path)

    def simulated(show_share: Callable[[float], object]) -> sn.Run:
        duration_s = max(scene.duration_s, scene.dt_s)
        return sn.simulate(scene, lambda t_s: show_share(t_s / duration_s), accuracy=accuracy)

    try:
        run = busy("simulating", simulated)
        if csv is not None:
            run.to_csv(csv)
    except KeyboardInterrupt:
        say("nothing of this run is kept", err=True)
        raise
    if figure is not None:
        run.plot(figure)
    report.wrote(saved_path, csv, figure)
    summary = busy("estimating the error", lambda _: run_report.run_summary(run, not no_error))
    if as_json:
        show_json({"gait": describe(scene.gait)} | summary | snake.notes)
    else:
        run_report.show_run(run, summary, verbose)


def make_scene(base: sn.Scene | None, snake: Snake, servo: str | None, values: Values) -> sn.Scene:
    """Make a scene of typed values, over `base` if there is one."""
    names = {field.name for field in fields(sn.Scene)}
    changes = {name: value for name, value in values.items() if name in names}
    for name in ANGLES & values.keys():
        changes[name.replace("_deg", "_rad")] = math.radians(values[name])
    kind = take_servo(servo or IDEAL, values, snake)
    if servo is not None:
        drive = "angle" if kind is None else "servo"
        changes |= {"drive": drive, "servo": kind and kind.servo, "torque": None}
    changes |= {"robot": snake.robot, "ground": snake.ground}
    changes["gait"] = make_gait(values, base and base.gait)
    return sn.Scene(**changes) if base is None else replace(base, **changes)


@command()
@click.argument("what", metavar="SCENE|RECORDING", type=EXISTING)
@option(
    "--out",
    "page",
    "Page to write; it needs no other file. The scene's or recording's name, unless given.",
    type=OutFile(".html"),
)
@settings(*ROBOT, *FRICTION)
def view(what: Path, robot: str | None, page: Path | None, settings: Values) -> None:
    """Write a page in which the snake crawls: play and scrub; slip and sticking of wheels.

    It takes a scene file, or a recording of `serpenoid drive --record`. Of a recording it shows
    how the robot and ground of the options move while the joints follow the recorded set-points.
    """
    from ..model.gait import gait_name
    from ..robot.recording.stream import load_stream
    from ..show.pages import view_page
    from ..show.run_figure import scene_words

    page = page or Path(f"{what.stem}.html")
    if what.suffix == ".toml":
        if robot is not None or settings:
            raise click.UsageError(
                "a scene file has its own robot and ground; leave the options out"
            )
        scene = sn.load_scene(what)
        run = busy("simulating", lambda _: sn.simulate(scene))
        about = scene_words(scene).replace("\n", "; ")
        shown = view_page.of_run(run)
    else:
        snake = make_snake(robot, settings)
        arguments = load_stream(what), snake.robot, snake.ground
        gait, shown = busy("predicting", lambda _: view_page.of_recording(*arguments))
        about = (
            f"{gait_name(gait)}; the path is predicted for the robot and ground of {robot or 2005}"
            f"{', changed' if settings else ''} from the set-points that the firmware reported"
        )
    view_page.write_page(page, what.stem.replace("_", " "), about, shown)
    say(f"wrote {page}; open it in a browser")


BROUGHT = Path(_core.__file__).parent


@command()
@click.argument("folder", type=FOLDER)
def examples(folder: Path) -> None:
    """Copy example scripts, example scenes and the 2005 session into a new FOLDER."""
    if folder.exists():
        raise click.UsageError(f"{folder} exists already; name a new folder")
    bare = shutil.ignore_patterns("__pycache__")  # pip compiles what it installs
    shutil.copytree(BROUGHT / "examples", folder, ignore=bare)
    shutil.copytree(BROUGHT / "calibration_data", folder / "calibration_data", ignore=bare)
    scene = folder / "limping_on_a_slope.toml"
    say(f"try: serpenoid simulate --scene {scene} --plot run.png")
