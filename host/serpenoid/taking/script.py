"""Take a session without prompts, from a script: a simulated person, or a list of readings.

A script such as plan.toml is one of

[simulated]                       [[reading]]
seed = 1                          kind = "station"
ct = 0.084   # whole snake        lambda_deg = 0.0
...                               incline_deg = 2.3
                                  belt_speed_m_s = 0.45
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ..base.errors import BadInput
from ..base.toml_table import Table, located
from ..model.ground import Ground
from ..servos.catalogue import HOBBY
from ..session.crawls import driving
from ..session.folder import TRACK_WORDS, content
from ..session.journal import Journal
from .parse_number import typed_cells
from .simulated import SimulatedPerson, Truth, take_all, wheel_inertia_kg


def run_script(journal: Journal, path: Path, tell: Callable[[str], object]) -> int:
    """Take the remaining readings of a session from a script; return the number of new readings.

    path: the script. tell: called with each step of a simulated person, in words. The simulated
    robot's joints have a hobby servo, sampled with the seed from those that predictions assume.
    Raises BadInput, naming file and line.
    """
    top = Table.load(path)
    if not {"reading", "simulated"} & set(top.values):
        raise BadInput(f"{path}: a script has tables [[reading]], or one table [simulated]")
    top.check_keys("reading" if "reading" in top.values else "simulated")
    if "reading" in top.values:
        return _add_listed(journal, top)
    table, frictions = top.table("simulated"), ("ct", "cn", "ft0", "fn0")
    table.check_keys("seed", *frictions)
    seed, previous, setup = table.integer("seed"), journal.last, journal.session.setup
    ground = Ground(*(table.number(name, 0.0) for name in frictions))
    servo, rolling_kg = driving(setup, HOBBY).draws(1, seed)[0], wheel_inertia_kg(setup)
    truth = Truth(ground, servo=servo, rolling_kg=rolling_kg)
    take_all(journal, SimulatedPerson(setup, truth, seed), tell)
    return journal.last - previous


def _add_listed(journal: Journal, top: Table) -> int:
    """Add the readings of a list that the session has not got; return how many these are."""
    listed = top.values["reading"]
    if not isinstance(listed, list) or not all(isinstance(row, dict) for row in listed):
        raise BadInput(f"{top.where('reading')}: give readings as [[reading]] tables")
    present, readings = Counter(map(content, journal.rows.values())), list[Any]()
    for number, table in enumerate(listed, 1):
        cells = dict(table)
        kind, comment = str(cells.pop("kind", "station")), str(cells.pop("comment", ""))
        with located(f"{top.path}: reading {number}"):
            cells = typed_cells(kind, cells, journal.session.setup)
            row, track = journal.check(kind, cells)
        key = content(row | ({TRACK_WORDS[1]: track.sha256} if track else {}))
        present[key] -= 1
        if present[key] < 0:
            readings.append((kind, cells, comment))
    for kind, cells, comment in readings:
        journal.add(kind, cells, comment=comment)
    return len(readings)
