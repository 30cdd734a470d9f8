"""Solve the benchmark's viscous problems again: the end states of bench/references.json."""

from __future__ import annotations

import json

from scipy.integrate import solve_ivp
from serpenoid.bench.peers import numba_equations as q
from serpenoid.bench.problems import FILE, as_kept, problems


def main() -> None:
    """Solve each by SciPy's DOP853; it is known to the distance from Numba's."""
    kept = json.loads(FILE.read_text())
    for problem in problems():
        if problem.ground.dry:
            continue  # kept as it is
        p, first, end_s = q.parameters(problem), problem.first, problem.duration_s
        implicit = problem.implicit
        other, _ = q.dop853_run(implicit, first, p, end_s, 1e-13, 1e-15, 10**8)
        end = solve_ivp(
            lambda t, y, p=p, implicit=implicit: q.rate_array(implicit, t, y, p),
            (0, end_s),
            first,
            "DOP853",
            rtol=1e-13,
            atol=1e-15,
        ).y[:, -1]
        kept[problem.name] = {
            "problem": as_kept(problem),
            "first": first.tolist(),
            "end": end.tolist(),
            "known_to": max(problem.error(other, end), 1e-14),
        }
    FILE.write_text(json.dumps(kept, indent=1) + "\n")


if __name__ == "__main__":
    main()
