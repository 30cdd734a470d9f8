"""The command `serpenoid examples`: copy out the examples and sessions that came along."""

from __future__ import annotations

import shutil
from pathlib import Path

import click

from .. import _core
from ..show.screen import say
from .options import AS_JSON, show_json
from .paths import FOLDER

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
