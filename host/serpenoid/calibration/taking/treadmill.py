"""The treadmill as an interface: whoever sets it and reads it, a person or a simulation."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Protocol

from ...model.errors import NotConverged
from ..kinds.declaration import Cells, Field
from ..kinds.table import KINDS
from ..session import Session
from .journal import Journal
from .procedure import doubts, next_step, skipped_keys
from .steps import Step, Tracked

MOST_STEPS = 1000


class Treadmill(Protocol):
    """Sets what a step says and answers with what was read, column -> number.

    A simulated one answers with what a person there could read, never with a truth. For each kind
    of step (`Step.kind`) it returns the numbers of `step.fields`, in the columns' units:
    zero (incline_deg, reversed_deg), bend (between_links_deg, between the last two links at an end
    of a robot bent as `step.bend` says), station (incline_deg, belt_speed_m_s, drift_m_s, and as
    far as they are known turned_deg, offset_deg and waited_s), belt (belt_speed_m_s, distance_m,
    duration_s of a mark on the belt), gait (distance_m, duration_s,
    omega_rad_s; or a `Tracked` of kind `video`), coast (distance_m, duration_s, or a `Tracked` with
    the track of a push); straight has none. A person who types takes the same steps
    (`person.dialogue`): a lab that is practised with moves its belt and robot beside it, by
    SessionRobot's calls and by what is set at the treadmill.
    """

    def answer(self, step: Step, session: Session) -> Cells | None:
        """Do a step; return its fields' numbers, or None if it cannot be done."""
        ...

    def look_again(
        self, step: Step, doubtful: Sequence[tuple[Field, tuple[float, float]]], cells: Cells
    ) -> Cells:
        """Return the numbers after reading those again that are not where they were expected."""
        ...


class Posture:
    """How the robot lies, in degrees of the plan's bend; None when that is not known; facing."""

    def __init__(self) -> None:
        self.bend_deg: float | None = None
        self.facing = "down"

    def after(self, step: Step) -> None:
        """Note that a step was done."""
        if step.kind in ("straight", "bend"):
            self.bend_deg, self.facing = step.lambda_deg, step.facing
        elif step.kind == "gait":
            self.bend_deg = None


def take_step(record: Journal, treadmill: Treadmill, posture: Posture) -> Step:
    """Do the next step of a session and record it; return it, kind "done" at the end."""
    session = record.session
    step = next_step(session, skipped_keys(record.events), posture.bend_deg, posture.facing)
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
    watch = record.session.setup.stopwatch
    values = KINDS[step.kind].derive(dict(step.cells) | dict(cells), watch)
    samples = cells.samples if isinstance(cells, Tracked) else None
    return record.add(step.kind, values, samples=samples)


def take_steps(record: Journal, treadmill: Treadmill) -> Iterator[Step]:
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


def take_all(record: Journal, treadmill: Treadmill) -> Session:
    """Take every step that is left of a session; return the session. Raises NotConverged."""
    for _ in take_steps(record, treadmill):
        pass
    return record.session
