"""The procedure taken step by step by somebody who answers, and each answer recorded."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from ..base.errors import NotConverged
from ..session.declaration import Cells
from ..session.journal import Journal
from ..session.rows import KINDS
from ..session.session import Session
from .procedure import doubts, next_step
from .steps import Step, Tracked

if TYPE_CHECKING:
    from .simulated import SimulatedPerson

MOST_STEPS = 1000


def posed_after(step: Step, before_deg: float | None) -> float | None:
    """Return how the robot lies after a step, deg of the plan's bend; None where nobody knows."""
    if step.kind in ("straight", "bend"):
        return step.lambda_deg
    return None if step.kind == "gait" else before_deg


def take_steps(record: Journal, treadmill: SimulatedPerson) -> Iterator[Step]:
    """Take every step that is left of a session, and yield it when done. Raises NotConverged."""
    posed_deg: float | None = None
    for _ in range(MOST_STEPS):
        session = record.session
        step = next_step(session, posed_deg)
        if step.kind == "done":
            return
        cells = treadmill.answer(step, session)
        if cells is None:
            record.event("skip", detail=step.key)
        else:
            doubtful = doubts(session, step, cells)
            record_step(
                record, step, treadmill.look_again(step, doubtful, cells) if doubtful else cells
            )
            posed_deg = posed_after(step, posed_deg)
        yield step
    raise NotConverged(
        f"{MOST_STEPS} steps and no end: does the treadmill's incline rise at all? Look at the "
        "readings with `serpenoid calibrate status`"
    )


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


def take_all(record: Journal, treadmill: SimulatedPerson) -> Session:
    """Take every step that is left of a session; return the session. Raises NotConverged."""
    for _ in take_steps(record, treadmill):
        pass
    return record.session
