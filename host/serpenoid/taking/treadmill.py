"""The procedure taken step by step by somebody who answers, and each answer recorded."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from ..base.errors import NotConverged
from ..session.declaration import Cells
from ..session.journal import Journal
from ..session.rows import KINDS
from ..session.session import Session
from .procedure import next_step
from .steps import Step, Tracked

if TYPE_CHECKING:
    from .simulated import SimulatedPerson

MAX_STEPS = 1000


def take_all(
    record: Journal,
    person: SimulatedPerson,
    show_step: Callable[[Step], object] = lambda step: None,
) -> Session:
    """Take every step that is left of a session; return the session. Raises NotConverged.

    show_step: is called with each step when it is done.
    """
    posed_deg: float | None = None
    for _ in range(MAX_STEPS):
        step = next_step(record.session, posed_deg)
        if step.kind == "done":
            return record.session
        cells = person.answer(step)
        if cells is None:
            record.event("skip", detail=step.key)
        else:
            record_step(record, step, cells)
            posed_deg = step.posed_deg
        show_step(step)
    raise NotConverged(
        f"{MAX_STEPS} steps and no end: does the treadmill's incline rise at all? Look at the "
        "readings with `serpenoid calibrate status`"
    )


def record_step(record: Journal, step: Step, cells: Cells) -> int:
    """Write what a step came to; return the reading's number, 0 where none is kept."""
    if step.kind == "straight":
        return 0
    reading = cells if isinstance(cells, Tracked) else Tracked(cells)
    kind = reading.kind or step.kind
    values = KINDS[kind].derived(step.cells | reading, record.session.setup.instruments)
    return record.add(kind, values, samples=reading.samples)
