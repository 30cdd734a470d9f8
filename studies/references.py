"""Solve the benchmark's viscous problems again: the end states of bench/references.json."""

from __future__ import annotations

import json

from serpenoid.bench.problems import FILE, problems
from serpenoid.bench.scipy_peer import solve


def main() -> None:
    """Solve each by SciPy's DOP853; it is known to the distance from one ten times looser."""
    solutions = json.loads(FILE.read_text())
    for problem in problems():
        if problem.scene.ground.dry:
            continue  # kept as it is
        end, coarse_end = (solve(problem, "DOP853", tolerance) for tolerance in (1e-13, 1e-12))
        solutions[problem.name] = {
            "end": end.tolist(),
            "known_to": max(problem.error(coarse_end, end), 1e-14),
        }
    FILE.write_text(json.dumps(solutions, indent=1) + "\n")


if __name__ == "__main__":
    main()
