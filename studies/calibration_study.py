"""Run a study of the calibration, over simulated sessions whose truth is known.

python studies/calibration_study.py coverage --sessions 1000    how often 95 % intervals hold it
python studies/calibration_study.py floor --sessions 1000       the same, of pushes on a floor
"""

from __future__ import annotations

import argparse
import json
from dataclasses import asdict
from pathlib import Path

import calibration_figures as figures
import coverage_floor
import coverage_treadmill

STUDIES = {
    "coverage": (coverage_treadmill.STUDY.run, figures.coverage_figure),
    "floor": (coverage_floor.STUDY.run, figures.coverage_figure),
}


def main() -> None:
    """Run one, and write its rows and their figure."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("study", choices=STUDIES)
    parser.add_argument("--sessions", type=int, required=True, help="of each kind; 20 at least")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=Path, default=Path("bench-out"))
    arguments = parser.parse_args()
    run, draw = STUDIES[arguments.study]
    results = list(run(arguments.sessions, arguments.seed, print))
    rows = [asdict(row) for row in results]
    arguments.out.mkdir(parents=True, exist_ok=True)
    path = arguments.out / f"{arguments.study}.json"
    path.write_text(json.dumps(rows, indent=2) + "\n")
    draw(rows, path.with_suffix(".png"))
    print(*rows, sep="\n")


if __name__ == "__main__":
    main()
