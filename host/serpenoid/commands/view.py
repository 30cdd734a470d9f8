"""The commands that show: a scene or a recording as a page; the examples."""

from __future__ import annotations

import itertools
import shutil
import webbrowser
from pathlib import Path
from typing import Any

import click

import serpenoid as sn

from .. import _core
from ..show.screen import say
from .declare import FOLDER, flag, option, out_file
from .options import AS_JSON, describe, interruptible, make_robot, robot_options, show_json


@click.command()
@click.argument("what", metavar="SCENE|RECORDING")
@robot_options
@option(
    "--out",
    "Page to write; it needs no other file. view.html, or a free view-N.html.",
    type=out_file(".html"),
)
@flag("--open", "open_it", "Open the page in the browser.")
@AS_JSON
def view(what: str, out: Path | None, open_it: bool, as_json: bool, **given: Any) -> None:
    """Write a page in which the snake crawls: play, scrub, slow down; slip and sticking of wheels.

    WHAT is a scene file or a recording of `serpenoid drive --record`. Of a recording it shows how
    the robot and ground of the options move while the joints follow the recorded set-points.
    """
    from ..robot.recording.stream import load_stream
    from ..show.pages import view_page
    from ..show.plot import gait_title
    from ..show.run_figure import scene_words

    if not Path(what).is_file():
        raise click.UsageError(
            f"{what!r} is no file; name a scene (.toml) or a recording of "
            "`serpenoid drive --record`"
        )
    if out is None:  # a name in this folder that no page has yet
        names = itertools.chain(["view.html"], (f"view-{k}.html" for k in itertools.count(2)))
        out = out_file(".html")(next(n for n in names if not Path(n).exists()))
    if what.endswith(".toml"):
        if any(value is not None for value in given.values()):
            raise click.UsageError(
                "a scene file has its own robot and ground; leave the options out"
            )
        scene = sn.load_scene(Path(what))
        run = interruptible(lambda: sn.simulate(scene))
        title, about = Path(what).stem.replace("_", " "), scene_words(scene).replace("\n", "; ")
        gait, shown = scene.gait, view_page.of_run(run)
    else:
        fitted = given["session"] or given["ground_file"]
        whose = f"{given['preset'] or 2005} robot and ground"
        whose = f"robot and ground of {fitted}" if fitted else whose
        robot, ground = make_robot(given)
        stream = load_stream(Path(what))
        gait, shown = interruptible(lambda: view_page.of_recording(stream, robot, ground))
        title = Path(what).name
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


@click.command()
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
