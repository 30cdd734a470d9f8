"""The commands simulate, view and examples."""

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
from ..base.checks import CHOICES, Limits
from ..show.screen import say
from .declare import (
    EXISTING,
    SETTINGS,
    OutFile,
    Setting,
    Values,
    command,
    flag,
    number,
    option,
    parsed_number,
    plain_text,
    settings,
)
from .options import (
    IDEAL,
    Snake,
    busy,
    describe,
    make_gait,
    make_snake,
    refuse_springs,
    show_json,
    typed_servo,
)


def _list(read: Callable[[str, str], Any]) -> Callable[[str, str], list[Any]]:
    """Return a reader of lists such as 2,4, with `read` for each part; `none` is the empty list."""
    return lambda name, text: [] if text == "none" else [read(name, x) for x in text.split(",")]


# Fields of Scene, angles in degrees. Torques and locked joints can be given in scene files only.
SETTINGS["scene"] = (
    Setting(
        "incline_direction_deg",
        "direction of uphill, from the x axis",
        "deg",
        Limits(-360, 360),
        "0",
    ),
    Setting(
        "limp", "joints without torque, such as 2,4; the tail's is 1", read=_list(parsed_number)
    ),
    Setting("dt_s", "time step", "s", usual="0.001"),
    Setting("tolerance", "error tolerance of methods with adaptive steps", usual="1e-7"),
    Setting(
        "start",
        f"state at time 0: {', '.join(CHOICES['start'])}",
        usual="zero_momentum",
        read=plain_text,
    ),
    Setting(
        "gap",
        f"implicit model: gaps of the joints at time 0: {', '.join(CHOICES['gap'])}",
        usual="slow_manifold",
        read=plain_text,
    ),
    Setting(
        "record", "what to record beside the motion: joints,friction,energy", read=_list(plain_text)
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
@number("--duration-s", "Length of the run; 10 s unless given.")
@option("--out", "csv", "CSV of all links at all recorded times.", type=OutFile(".csv"))
@option("--save-scene", "saved_path", "Write the scene to this file too.", type=OutFile(".toml"))
@settings("robot", "friction", "offset", "plug", "springs", "scene")
@option(
    "--method",
    "Method of integration; unless given, nonsmooth on dry ground, else rk4.",
    choice=(row["name"] for row in _core.method_table()),
    research=True,
)
@number(
    "--accuracy",
    "Choose the step, and the method unless given, for this error (body lengths, radians).",
    research=True,
)
@flag("--no-error", "Skip the extra runs that estimate the error.", research=True)
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
    """Simulate a scene: of a scene file, of options, or of a file that options change."""
    from ..show import report, run_report

    base = scene_path and sn.load_scene(scene_path)
    snake = make_snake(robot, settings, base and Snake(base.robot, base.ground))
    values = settings | typed_gait | {"formulation": formulation}
    typed = {name: value for name, value in values.items() if value is not None}
    scene = make_scene(base, snake, servo, typed)
    if scene.formulation == "explicit":
        refuse_springs(settings)
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
    """Return the scene of typed values; base: a scene that they change, if there is one."""
    names = {field.name for field in fields(sn.Scene)}
    changes = {name: value for name, value in values.items() if name in names}
    for name in values.keys() & {"incline_deg", "incline_direction_deg"}:
        changes[name.replace("_deg", "_rad")] = math.radians(values[name])
    kind = typed_servo(servo or IDEAL, values, snake)
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
    "Page to write, a single file; named after the scene or recording unless given.",
    type=OutFile(".html"),
)
@settings("robot", "friction")
def view(what: Path, robot: str | None, page: Path | None, settings: Values) -> None:
    """Write a page that animates the snake and shows where its wheels slip and stick.

    It takes a scene file, or a recording of `serpenoid drive --record`. A recording has only the
    joints' set-points; the page shows the motion predicted from them for the robot and ground of
    the options.
    """
    from ..model.gait import gait_name
    from ..robot.recording.stream import load_stream
    from ..show.pages import view_page
    from ..show.run_figure import scene_words

    page = page or Path(f"{what.stem}.html")
    if what.suffix == ".toml":
        if robot is not None or settings:
            raise click.UsageError(
                "a scene file has its own robot and ground; leave out --robot and --set"
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


@command()
def examples(folder: Path) -> None:
    """Copy example scripts, example scenes and the 2005 session into a new FOLDER."""
    if folder.exists():
        raise click.UsageError(f"{folder} exists already; name a new folder")
    installed = Path(_core.__file__).parent
    ignored = shutil.ignore_patterns("__pycache__")  # pip compiles the scripts that it installs
    shutil.copytree(installed / "examples", folder, ignore=ignored)
    shutil.copytree(installed / "calibration_data", folder / "calibration_data", ignore=ignored)
    scene = folder / "limping_on_a_slope.toml"
    say(f"try: serpenoid simulate --scene {scene} --plot run.png")
