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

from ...model.errors import BadInput
from ...model.ground import Ground
from ...model.toml_table import Table, located
from ..session import Setup
from .journal import Journal, Listed
from .parse_number import completed, listed_cells
from .simulated import GaitSpeed, SimulatedTreadmill
from .steps import Step
from .treadmill import MOST_STEPS, Posture, Treadmill, take_step
from .world import Truth

_BACK = ("ct_back", "ft0_back")  # of ratchet wheels; as forwards unless given
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
Told = Callable[[Step], None]


def load_script(path: Path) -> Table:
    """Read a script; raises BadInput, naming file and line."""
    top = Table.load(path)
    top.only(optional=("simulated", "reading", "robot", "laboratory"))
    if ("simulated" in top.values) == ("reading" in top.values):
        raise BadInput(f"{path}: give either [simulated] or a list of [[reading]]")
    return top


def wanted_setup(top: Table, session: Setup) -> Setup:
    """Return a session's set-up with what a script says of robot and laboratory put in."""
    from dataclasses import replace

    if "robot" in top.values:
        table = top.table("robot")
        table.only(optional=("links", "link_mass_kg", "link_length_m"))
        with located(table.heading):
            session = replace(session, robot=replace(session.robot, **dict(table.values)))
    if "laboratory" in top.values:
        table = top.table("laboratory")
        table.only("surface")
        session = replace(session, surface=table.string("surface"))
    return session


def simulated_treadmill(
    top: Table, setup: Setup, gait_speed: GaitSpeed | None = None
) -> SimulatedTreadmill:
    """Return the treadmill that a script's [simulated] describes; raises BadInput."""
    table = top.table("simulated")
    table.only("seed", "ct", "cn", "ft0", "fn0", optional=_TRUTH + _BACK)
    ct, cn, ft0, fn0 = (table.number(name, 0.0) for name in ("ct", "cn", "ft0", "fn0"))
    back = [table.number(n, 0.0) if n in table.values else None for n in _BACK]
    ground = Ground(
        ct if back[0] is None else (ct, back[0]),
        cn,
        ft0 if back[1] is None else (ft0, back[1]),
        fn0,
    )
    given = {n: table.number(n) for n in _TRUTH if n in table.values}
    in_si: dict[str, Any] = {
        n.replace("_deg", "_rad"): math.radians(v) if n.endswith("_deg") else v
        for n, v in given.items()
    }
    truth = Truth(ground, **in_si)
    return SimulatedTreadmill(setup, truth, table.whole("seed"), gait_speed)


def run_script(
    journal: Journal, top: Table, told: Told, gait_speed: GaitSpeed | None = None
) -> int:
    """Take what is left of a session as a script says; return how many steps were done."""
    if "reading" in top.values:
        return _add_listed(journal, top)
    treadmill = simulated_treadmill(top, journal.session.setup, gait_speed)
    return _take(journal, treadmill, told)


def _take(journal: Journal, treadmill: Treadmill, told: Told) -> int:
    posture = Posture()
    for done in range(MOST_STEPS):
        step = take_step(journal, treadmill, posture)
        if step.kind == "done":
            return done
        told(step)
    raise BadInput(f"{journal.folder}: {MOST_STEPS} steps and no end; look at `calibrate status`")


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
            cells = completed(kind, listed_cells(kind, cells), journal.session.setup)
            journal.check(kind, cells)
        made.append((kind, cells, comment))
    return journal.add_once(made)
