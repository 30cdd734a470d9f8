"""A session taken without prompts: plan.toml says who answers, a simulation or a list of readings.

[simulated]                       [[reading]]
seed = 1                          kind = "station"
ct = 0.084   # whole snake        lambda_deg = 0.0
...                               incline_deg = 2.3
                                  belt_speed_m_s = 0.45
"""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ..base.errors import BadInput
from ..base.toml_table import Table, located
from ..model.ground import Ground
from ..session.journal import Journal, Listed
from ..session.settings import Setup
from .parse_number import completed, typed_cells
from .simulated import SimulatedPerson
from .steps import Step
from .treadmill import take_steps
from .world import Truth, wheel_inertia_kg

_FRICTIONS = ("ct", "cn", "ft0", "fn0")
_TRUTH = (
    "incline_zero_deg",
    "belt_scale",
    "mass_scale",
    "joint_sigma_deg",
    "link_spread",
    "rolling_kg",
    "breakaway",
    "disturbance_m_s",
    "misreads",
    "hasty",
    "short_s",
    "amplitude",
)


def load_script(path: Path) -> Table:
    """Read a script; raises BadInput, naming file and line."""
    top = Table.load(path)
    top.only(optional=("simulated", "reading"))
    if ("simulated" in top.values) == ("reading" in top.values):
        raise BadInput(f"{path}: give either [simulated] or a list of [[reading]]")
    return top


def simulated_treadmill(top: Table, setup: Setup) -> SimulatedPerson:
    """Return the treadmill that a script's [simulated] describes; raises BadInput."""
    table = top.table("simulated")
    table.only("seed", *_FRICTIONS, optional=_TRUTH)
    ct, cn, ft0, fn0 = (table.number(name, 0.0) for name in _FRICTIONS)
    given = {n: table.number(n) for n in _TRUTH if n in table.values}
    in_si: dict[str, Any] = {
        n.replace("_deg", "_rad"): math.radians(v) if n.endswith("_deg") else v
        for n, v in given.items()
    }
    if setup.plan.on == "floor":
        in_si.setdefault("rolling_kg", wheel_inertia_kg(setup))
    return SimulatedPerson(setup, Truth(Ground(ct, cn, ft0, fn0), **in_si), table.whole("seed"))


def run_script(journal: Journal, top: Table, told: Callable[[Step], None]) -> int:
    """Take what is left of a session as a script says; return how many steps were done."""
    if "reading" in top.values:
        return _add_listed(journal, top)
    done = 0
    for step in take_steps(journal, simulated_treadmill(top, journal.session.setup)):
        told(step)
        done += 1
    return done


def _add_listed(journal: Journal, top: Table) -> int:
    """Add those of the listed readings that the session has not got from this list already."""
    listed = top.values["reading"]
    if not isinstance(listed, list) or not all(isinstance(row, dict) for row in listed):
        raise BadInput(f"{top.where('reading')}: give readings as [[reading]] tables")
    made: list[Listed] = []
    for number, row in enumerate(listed, 1):
        cells = dict(row)
        kind, comment = str(cells.pop("kind", "station")), str(cells.pop("comment", ""))
        with located(f"{top.path}: reading {number}"):
            cells = completed(kind, typed_cells(kind, cells), journal.session.setup)
            journal.check(kind, cells)
        made.append((kind, cells, comment))
    return journal.add_once(made)
