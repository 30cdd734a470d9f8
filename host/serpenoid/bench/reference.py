"""The truth that the benchmark measures against, and how well it is known.

Viscous ground: SciPy's DOP853 at a tolerance of 1e-13 on the hand-written equations, compiled by
Numba (a test holds them to plain NumPy); they share nothing with the core. Known to the distance
from Numba's DOP853 at that tolerance. Dry ground: smooth motion between switching events by the
tests' reference (tests/oracle/contact_modes.py), known to what a tolerance a hundred times looser
changes. The stiff scenes take long, so all end states are kept in references.json;
`studies/references.py` solves the viscous ones again.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..model.errors import BadInput
from ..model.files import read_json
from .problems import Array, Problem

FILE = Path(__file__).with_name("references.json")


@dataclass(frozen=True, slots=True)
class Reference:
    """Hold an end state (the peers' vector) and the scaled error that it may itself have."""

    end: Array
    known_to: float


def as_kept(value: Any) -> Any:
    """Return a problem as words and numbers, without what has its default: fields may be added."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        fields = {f.name: (getattr(value, f.name), f.default) for f in dataclasses.fields(value)}
        return {name: as_kept(now) for name, (now, default) in fields.items() if now != default}
    return value


def reference(problem: Problem) -> Reference:
    """Return the end state kept for a problem; raise BadInput if it belongs to another one."""
    kept = read_json(FILE)[problem.name]
    moved = problem.error(problem.first, kept["first"])  # the slow manifold's, by rounding
    if kept["problem"] != as_kept(problem) or moved > 1e-10:
        raise BadInput(
            f"the reference kept for {problem.name} is of another problem or start; solve it "
            "again with `studies/references.py`"
        )
    return Reference(np.array(kept["end"]), max(kept["known_to"], moved))
