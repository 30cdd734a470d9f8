"""Draw the figures that the repository stores, from what it stores: `make figures`."""

from __future__ import annotations

import argparse
import json
import shutil
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "studies"))
from calibration_figures import advised_figure, coverage_figure, verdict_figure
from serpenoid.bench.accuracy.figure import accuracy_figure
from serpenoid.bench.accuracy.files import read_csv
from serpenoid.bench.stability.figure import overview
from serpenoid.bench.stability.files import read_cells
from serpenoid.commands.demo import run_demo

STORED = Path(__file__).resolve().parents[1] / "host" / "docs"


def speed(path: Path) -> None:
    """Draw the demo's prediction of speed against frequency (Fig. 17)."""
    with tempfile.TemporaryDirectory() as folder:
        run_demo(Path(folder))
        shutil.copy(Path(folder) / "speed.png", path)


def accuracy(path: Path) -> None:
    """Draw the measurement that stands in accuracy.csv; `serpenoid bench accuracy` measures."""
    found = json.loads((STORED / "accuracy.json").read_text())
    where = f"{found['cpu']}, {found['compiler']}, one core"
    accuracy_figure(read_csv(STORED / "accuracy.csv"), path, where)


def stability(path: Path) -> None:
    """Draw the maps that stand in stability.csv; `serpenoid bench stability` measures."""
    overview(read_cells(STORED / "stability.csv"), path)


def coverage(path: Path) -> None:
    """Draw the study that stands in coverage.json; `studies/calibration_study.py` makes it."""
    coverage_figure(json.loads((STORED / "coverage.json").read_text()), path)


def advise(path: Path) -> None:
    """Draw the study that stands in advise.json; `studies/calibration_study.py` makes it."""
    advised_figure(json.loads((STORED / "advise.json").read_text()), path)


def verdict(path: Path) -> None:
    """Draw the study that stands in verdict.json; `studies/calibration_study.py` makes it."""
    verdict_figure(json.loads((STORED / "verdict.json").read_text()), path)


FIGURES: dict[str, Callable[[Path], None]] = {
    "speed.png": speed,
    "accuracy.png": accuracy,
    "stability.png": stability,
    "coverage.png": coverage,
    "advise.png": advise,
    "verdict.png": verdict,
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
