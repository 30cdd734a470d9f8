"""The truth that the benchmark measures against, how it was found, and how well it is known.

Viscous ground: SciPy's DOP853 at a tolerance of 1e-13 on the hand-written equations, compiled by
Numba (a test holds them to plain NumPy); they share nothing with the core. Known to the distance
from Numba's own DOP853 at that tolerance. Dry ground: smooth motion between switching events by the
tests' reference (tests/oracle/bingham.py), known to what a tolerance a hundred times looser
changes. The stiff scenes take long, so all end states are kept in references.json;
`python -m serpenoid.bench.reference` finds the viscous ones again.
"""

from __future__ import annotations

import dataclasses
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..model.errors import BadInput
from .problems import Array, Problem, problems

FILE = Path(__file__).with_name("references.json")


@dataclass(frozen=True, slots=True)
class Reference:
    """Hold an end state (the peers' vector) and the scaled error that it may itself have."""

    end: Array
    known_to: float


def told(value: Any) -> Any:
    """Return a problem as words and numbers, without what has its default: fields may be added."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        fields = {f.name: (getattr(value, f.name), f.default) for f in dataclasses.fields(value)}
        return {name: told(now) for name, (now, default) in fields.items() if now != default}
    return [told(one) for one in value] if isinstance(value, (list, tuple)) else value


def reference(problem: Problem) -> Reference:
    """Return the end state kept for a problem; raise BadInput if it belongs to another one."""
    kept = json.loads(FILE.read_text())[problem.name]
    moved = problem.error(problem.first, kept["first"])  # the slow manifold's, by rounding
    if kept["problem"] != told(problem) or moved > 1e-10:
        raise BadInput(
            f"the reference kept for {problem.name} is of another problem or start; find it again "
            "with `python -m serpenoid.bench.reference`"
        )
    return Reference(np.array(kept["end"]), max(kept["known_to"], moved))


def solve(problem: Problem) -> Array:
    """Return the end state on viscous ground by SciPy's DOP853."""
    from scipy.integrate import solve_ivp

    from .peers.numba_equations import parameters, rate_array

    p = parameters(problem)
    out = solve_ivp(
        lambda t, y: rate_array(problem.implicit, t, y, p),
        (0, problem.duration_s),
        problem.first,
        "DOP853",
        rtol=1e-13,
        atol=1e-15,
    )
    return out.y[:, -1]


def keep(problem: Problem, end: Array, known_to: float) -> None:
    """Write a problem's reference into the file."""
    kept = json.loads(FILE.read_text()) if FILE.exists() else {}
    kept[problem.name] = {
        "problem": told(problem),
        "first": problem.first.tolist(),
        "end": list(end),
        "known_to": known_to,
    }
    FILE.write_text(json.dumps(kept, indent=1) + "\n")


def _check(problem: Problem) -> Array:
    from .peers import numba_equations as q

    p = q.parameters(problem)
    args = (problem.first, p, problem.duration_s, 1e-13, 1e-15, 10**8)
    return q.dop853_run(problem.implicit, *args)[0]


if __name__ == "__main__":
    for one in problems():
        if not one.ground.dry:
            found = solve(one)
            keep(one, found, max(one.error(_check(one), found), 1e-14))
