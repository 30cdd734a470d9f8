"""The commands on runs in time: simulate, view a scene or a recording, copy examples."""

from __future__ import annotations

import math
import shutil
import webbrowser
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import click

import serpenoid as sn

from .. import _core
from ..base.checks import FORMULATIONS, GAPS, STARTS, Limits
from ..show.screen import say
from ..simulation.scene import METHODS
from .declare import (
    EXISTING,
    FIGURES,
    FOLDER,
    OutFile,
    Setting,
    Values,
    chosen,
    command,
    flag,
    number,
    option,
    parsed_number,
    refuse_unused,
    settings,
)
from .options import (
    AS_JSON,
    AS_TABLES,
    FRICTION,
    GAIT_FIELDS,
    IDEAL,
    OFFSET,
    PINNED,
    PLUG,
    ROBOT,
    SPRINGS,
    Snake,
    busy,
    describe,
    gait_options,
    make_gait,
    make_snake,
    robot_option,
    servo_option,
    show_json,
    take_servo,
)


def _list(read: Callable[[str, str], Any]) -> Callable[[str, str], list[Any]]:
    """Return what reads a list with commas, each part by `read`; `none` is an empty one."""
    return lambda name, text: [] if text == "none" else [read(name, x) for x in text.split(",")]


def _text(_name: str, text: str) -> str:
    return text


# Fields of Scene, angles in degrees. Joint torques and locked joints are for scene files.
SCENE = (
    Setting("incline_direction_deg", "uphill, from the x axis", "deg", Limits(-360, 360), "0"),
    Setting("limp", "joints without torque, from 1 at the tail: 2,4", read=_list(parsed_number)),
    Setting("dt_s", "time step", "s", usual="0.001"),
    Setting("tolerance", "of methods that pick their steps", usual="1e-7"),
    Setting("start", f"state at time 0: {', '.join(STARTS)}", usual="zero_momentum", read=_text),
    Setting(
        "gap",
        f"implicit model: how the joints start open: {', '.join(GAPS)}",
        usual=GAPS[0],
        read=_text,
    ),
    Setting("record", "what to keep beside the motion: joints,friction,energy", read=_list(_text)),
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
@robot_option
@gait_options
@servo_option
@number("--incline-deg", "Slope of the ground, uphill along the x axis.", limits=Limits(0, 90))
@number("--duration-s", "Length of the run; 10.")
@option("--out", "csv", "CSV of all links at all recorded times.", type=OutFile(".csv"))
@option(
    "--plot",
    "figure",
    "PNG, PDF or SVG of path, speed and energy if recorded.",
    type=OutFile(*FIGURES),
)
@option("--save-scene", "saved_path", "Write the scene to this file too.", type=OutFile(".toml"))
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
    csv: Path | None,
    figure: Path | None,
    accuracy: float | None,
    no_error: bool,
    verbose: bool,
    as_json: bool,
    **typed: Any,
) -> None:
    """Follow one scene in time: a scene file, options, or a file with options over it."""
    from ..show import report, run_report

    settings = typed["settings"]
    scene, notes = make_scene(scene_path and sn.load_scene(scene_path), **typed)
    if scene.formulation == "explicit":
        refuse_unused(settings, PINNED, "joint_stiffness_n_m", "joint_damping_n_s_m", "gap")
    if accuracy is not None or not scene.adaptive:
        steps = f"--accuracy chooses it, and method {scene.method!r} takes fixed steps, dt_s"
        refuse_unused(settings, steps, "tolerance")
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
        show_json({"gait": describe(scene.gait)} | summary | notes)
    else:
        run_report.show_run(run, summary, verbose)


def make_scene(
    base: sn.Scene | None,
    robot: str | None,
    servo: str | None,
    settings: Values,
    **typed: Any,
) -> tuple[sn.Scene, Values]:
    """Make a scene of the options, over a scene file's if there is one.

    typed: options of the gait, and those that are named as a scene's fields.

    Returns the scene, and what JSON says of the fit that it rests on.
    """
    snake = make_snake(robot, settings, base and Snake(base.robot, base.ground))
    fields = chosen(settings, *SCENE, *SPRINGS)
    fields |= {n: v for n, v in typed.items() if v is not None and n not in GAIT_FIELDS}
    for name in {"incline_deg", "incline_direction_deg"} & fields.keys():
        fields[name.replace("_deg", "_rad")] = math.radians(fields.pop(name))
    kind = take_servo(servo or IDEAL, settings, snake)
    if servo is not None:
        drive = "angle" if kind is None else "servo"
        fields |= {"drive": drive, "servo": kind and kind.servo, "torque": None}
    fields["gait"] = make_gait(typed, settings, base and base.gait)
    fields |= {"robot": snake.robot, "ground": snake.ground}
    scene = sn.Scene(**fields) if base is None else replace(base, **fields)
    return scene, snake.notes


@command()
@click.argument("what", metavar="SCENE|RECORDING", type=EXISTING)
@robot_option
@option(
    "--out",
    "page",
    "Page to write; it needs no other file. The scene's or recording's name, unless given.",
    type=OutFile(".html"),
)
@flag("--open", "open_it", "Open the page in the browser.")
@settings(*ROBOT, *FRICTION)
@AS_JSON
def view(
    what: Path, robot: str | None, page: Path | None, open_it: bool, settings: Values, as_json: bool
) -> None:
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
        title, about = what.stem.replace("_", " "), scene_words(scene).replace("\n", "; ")
        gait, shown = scene.gait, view_page.of_run(run)
    else:
        snake = make_snake(robot, settings)
        whose = f"robot and ground of {robot or 2005}{', changed' if settings else ''}"
        arguments = load_stream(what), snake.robot, snake.ground
        title, (gait, shown) = (
            what.name,
            busy("predicting", lambda _: view_page.of_recording(*arguments)),
        )
        about = (
            f"{gait_name(gait)}; the path is predicted for the {whose} "
            "from the set-points that the firmware reported"
        )
    view_page.write_page(page, title, about, shown)
    if open_it:
        webbrowser.open(page.resolve().as_uri())
    if as_json:
        show_json({"page": str(page), "duration_s": shown["t_s"][-1], "gait": describe(gait)})
    else:
        say(f"wrote {page}; open it in a browser")


BROUGHT = Path(_core.__file__).parent


@command()
@click.argument("folder", type=FOLDER)
@AS_JSON
def examples(folder: Path, as_json: bool) -> None:
    """Copy example scripts, example scenes and the 2005 session into a new FOLDER."""
    if folder.exists():
        raise click.UsageError(f"{folder} exists already; name a new folder")
    bare = shutil.ignore_patterns("__pycache__")  # pip compiles what it installs
    shutil.copytree(BROUGHT / "examples", folder, ignore=bare)
    shutil.copytree(BROUGHT / "calibration_data", folder / "calibration_data", ignore=bare)
    files = sorted(str(path) for path in folder.rglob("*") if path.is_file())
    if as_json:
        return show_json({"files": files})
    scene = folder / "limping_on_a_slope.toml"
    say(f"{len(files)} files; try: serpenoid simulate --scene {scene} --plot run.png")
