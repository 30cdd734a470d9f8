"""The procedure taken step by step by somebody who answers, and each answer recorded."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from ..base.errors import NotConverged
from ..session.declaration import Cells
from ..session.journal import Journal
from ..session.kinds import KINDS
from ..session.session import Session
from .procedure import doubts, next_step
from .steps import Step, Tracked

if TYPE_CHECKING:
    from .simulated import SimulatedPerson

MOST_STEPS = 1000


class Posture:
    """How the robot lies, in degrees of the plan's bend; None when that is not known."""

    def __init__(self) -> None:
        self.bend_deg: float | None = None

    def after(self, step: Step) -> None:
        """Note that a step was done."""
        if step.kind in ("straight", "bend"):
            self.bend_deg = step.lambda_deg
        elif step.kind == "gait":
            self.bend_deg = None


def take_step(record: Journal, treadmill: SimulatedPerson, posture: Posture) -> Step:
    """Do the next step of a session and record it; return it, kind "done" at the end."""
    session = record.session
    step = next_step(session, posture.bend_deg)
    if step.kind == "done":
        return step
    cells = treadmill.answer(step, session)
    if cells is None:
        record.event("skip", detail=step.key)
        return step
    doubtful = doubts(session, step, cells)
    if doubtful:
        cells = treadmill.look_again(step, doubtful, cells)
    record_step(record, step, cells)
    posture.after(step)
    return step


def record_step(record: Journal, step: Step, cells: Cells) -> int:
    """Write what a step's fields came to; return the reading's number, 0 where none is kept."""
    if step.kind == "straight":
        return 0
    if isinstance(cells, Tracked) and cells.kind:
        way = {name: step.cells[name] for name in ("way",) if name in step.cells}
        return record.add(cells.kind, {**cells, **way}, samples=cells.samples)
    watch = record.session.setup.instruments
    values = KINDS[step.kind].derived(dict(step.cells) | dict(cells), watch)
    samples = cells.samples if isinstance(cells, Tracked) else None
    return record.add(step.kind, values, samples=samples)


def take_steps(record: Journal, treadmill: SimulatedPerson) -> Iterator[Step]:
    """Take every step that is left of a session, and yield it when done. Raises NotConverged."""
    posture = Posture()
    for _ in range(MOST_STEPS):
        step = take_step(record, treadmill, posture)
        if step.kind == "done":
            return
        yield step
    raise NotConverged(
        f"{MOST_STEPS} steps and no end: does the treadmill's incline rise at all? Look at the "
        "readings with `serpenoid calibrate status`"
    )


def take_all(record: Journal, treadmill: SimulatedPerson) -> Session:
    """Take every step that is left of a session; return the session. Raises NotConverged."""
    for _ in take_steps(record, treadmill):
        pass
    return record.session
