"""The commands that show: a scene or a recording as a page; the examples."""

from __future__ import annotations

import shutil
import webbrowser
from pathlib import Path

import click

import serpenoid as sn

from .. import _core
from ..show.screen import say
from .declare import EXISTING, FOLDER, Given, command, flag, option, out_file, settings
from .given import make_snake
from .options import AS_JSON, FRICTION, ROBOT, busy, describe, robot_option, show_json


@command()
@click.argument("what", metavar="SCENE|RECORDING", type=EXISTING)
@robot_option
@option(
    "--out",
    "Page to write; it needs no other file. WHAT's name in this folder, unless given.",
    type=out_file(".html"),
)
@flag("--open", "open_it", "Open the page in the browser.")
@settings(*ROBOT, *FRICTION)
@AS_JSON
def view(
    what: Path, robot: str | None, out: Path | None, open_it: bool, settings: Given, as_json: bool
) -> None:
    """Write a page in which the snake crawls: play, scrub, slow down; slip and sticking of wheels.

    WHAT is a scene file or a recording of `serpenoid drive --record`. Of a recording it shows how
    the robot and ground of the options move while the joints follow the recorded set-points.
    """
    from ..robot.recording.stream import load_stream
    from ..show.pages import view_page
    from ..show.plot import gait_title
    from ..show.run_figure import scene_words

    out = out or Path(f"{what.stem}.html")
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
        of = load_stream(what), snake.robot, snake.ground
        title, (gait, shown) = what.name, busy("predicting", lambda _: view_page.of_recording(*of))
        about = (
            f"{gait_title(gait)}; the path is predicted for the {whose} "
            "from the set-points that the firmware reported"
        )
    view_page.write_page(out, title, about, shown)
    if open_it:
        webbrowser.open(out.resolve().as_uri())
    if as_json:
        show_json({"page": str(out), "duration_s": shown["t_s"][-1], "gait": describe(gait)})
    else:
        say(f"wrote {out}; open it in a browser")


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
    for name in files:
        say(name)
    say(f"try: serpenoid simulate --scene {folder}/limping_on_a_slope.toml --plot run.png")
