"""Draw the figures that the repository stores, from what it stores: `make figures`."""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "studies"))
import crawl_drawing
import film_pictures
import robot_drawing
import serpenoid as sn
import wiring_diagram
from serpenoid.base.files import csv_rows, read_text
from serpenoid.bench.stability_map import Cell, stability_figure
from serpenoid.bench.work_precision import Row
from serpenoid.bench.work_precision_figure import work_precision_figure
from serpenoid.paper.study import PATH_GAIT, path_run
from serpenoid.show import run_figure

ROOT = Path(__file__).resolve().parents[1]
STORED = ROOT / "host" / "docs"


def speed(path: Path) -> None:
    """Draw the speed of the 2005 robot over frequency, with its band, from its session."""
    session = sn.load_session(ROOT / "calibration_data" / "nirakh-2005")
    gaits = [sn.Gait.degrees(70, 75, hertz=hertz) for hertz in (0.2, 0.8)]
    sn.compare(session, gaits=gaits).plot(path)


def crawl_path(path: Path) -> None:
    """Draw the path of the paper's robot."""
    title = "the paper's robot, α = 30°, β = 80°, ω = 5 rad/s"
    run_figure.path_and_poses(path_run(PATH_GAIT, 3), title, path)


def run(path: Path) -> None:
    """Draw the example that limps on a slope."""
    scene = STORED.parent / "examples" / "limping_on_a_slope.toml"
    sn.simulate(sn.load_scene(scene)).plot(path)


def accuracy(path: Path) -> None:
    """Draw the measurement that stands in accuracy.csv; `serpenoid bench` measures."""
    work_precision_figure(measured_rows(), path)


def measured_rows() -> list[Row]:
    """Return the rows of accuracy.csv."""
    _, *lines = csv_rows(read_text(STORED / "accuracy.csv"))
    numbers = [[float(cell or "nan") for cell in line[3:6]] for line in lines]
    return [Row(*line[:3], *values, *line[6:]) for line, values in zip(lines, numbers, strict=True)]


def stability(path: Path) -> None:
    """Draw the map that stands in stability.csv; `serpenoid bench` measures."""
    _, *lines = csv_rows(read_text(STORED / "stability.csv"))
    cells = [Cell(line[0], *map(float, line[1:8])) for line in lines]  # type: ignore[arg-type]
    stability_figure(cells, path)


FIGURES = {
    "crawl.svg": crawl_drawing.draw,
    "speed.png": speed,
    "path.png": crawl_path,
    "run.png": run,
    "accuracy.png": accuracy,
    "stability.png": stability,
    "robot.svg": robot_drawing.draw,
    "wiring.svg": wiring_diagram.draw_file,
    "wiring_pca9685.svg": wiring_diagram.draw_file,
    "film-robot.png": film_pictures.draw,
    "film-tripod.png": film_pictures.draw,
}


def main() -> None:
    """Draw all of them into host/docs."""
    for name, draw in FIGURES.items():
        draw(STORED / name)
        print(STORED / name)


if __name__ == "__main__":
    main()
