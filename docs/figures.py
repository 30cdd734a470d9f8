"""Draw the figures that the repository stores, from what it stores: `make figures`."""

from __future__ import annotations

import argparse
import json
import shutil
import sys
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "studies"))
import crawl_drawing
import film_pictures
import robot_drawing
import serpenoid as sn
import wiring_diagram
from calibration_figures import coverage_figure
from serpenoid.bench.accuracy.figure import accuracy_figure
from serpenoid.bench.accuracy.measure import Row
from serpenoid.bench.rows import read_rows
from serpenoid.bench.stability.figure import stability_figure
from serpenoid.bench.stability.map import Cell
from serpenoid.commands.demo import run_demo
from serpenoid.show.run_figure import draw_run

STORED = Path(__file__).resolve().parents[1] / "host" / "docs"


@cache
def _demo() -> Path:
    """Return a folder with the demo's pictures."""
    folder = Path(tempfile.mkdtemp())
    run_demo(folder)
    return folder


def of_demo(path: Path) -> None:
    """Take the demo's picture of this name: speed over frequency (Fig. 17), or a path."""
    shutil.copy(_demo() / path.name, path)


def run(path: Path) -> None:
    """Draw the example that limps on a slope."""
    scene = STORED.parent / "examples" / "limping_on_a_slope.toml"
    draw_run(sn.simulate(sn.load_scene(scene)), path)


def accuracy(path: Path) -> None:
    """Draw the measurement that stands in accuracy.csv; `serpenoid bench accuracy` measures."""
    found = json.loads((STORED / "accuracy.json").read_text())
    where = f"{found['cpu']}, {found['compiler']}, one core"
    accuracy_figure(read_rows(STORED / "accuracy.csv", Row), path, where)


def stability(path: Path) -> None:
    """Draw the maps that stand in stability.csv; `serpenoid bench stability` measures."""
    stability_figure(read_rows(STORED / "stability.csv", Cell), path)


def study(path: Path) -> None:
    """Draw the study that stands in the JSON file; `studies/calibration_study.py` makes it."""
    coverage_figure(json.loads((STORED / f"{path.stem}.json").read_text()), path)


FIGURES: dict[str, Callable[[Path], None]] = {
    "crawl.svg": crawl_drawing.draw,
    "speed.png": of_demo,
    "path.png": of_demo,
    "run.png": run,
    "accuracy.png": accuracy,
    "stability.png": stability,
    "coverage.png": study,
    "robot.svg": robot_drawing.draw,
    "wiring.svg": wiring_diagram.draw_file,
    "wiring_pca9685.svg": wiring_diagram.draw_file,
    **{
        f"film-{part}.png": film_pictures.draw
        for part in ("tags", "robot", "tripod", "frame", "light")
    },
}


def main() -> None:
    """Draw all of them into a folder."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=STORED)
    out = parser.parse_args().out
    out.mkdir(parents=True, exist_ok=True)
    for name, draw in FIGURES.items():
        draw(out / name)
        print(out / name)


if __name__ == "__main__":
    main()
