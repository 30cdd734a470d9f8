"""A step of a session, the bends of its plan, and the readings taken in each of them."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..model.gait import Gait
from ..session.declaration import Cells, Field, Values
from ..session.folder import KINDS
from ..session.journal import Journal
from ..session.session import Session
from ..session.settings import Plan
from ..session.track import Samples


class Tracked(dict[str, "float | str"]):
    """Cells of a reading, with the samples of its track.

    kind: kind of the reading; "" for that of the step.
    """

    def __init__(self, cells: Cells, samples: Samples | None = None, kind: str = ""):
        super().__init__(cells)
        self.samples, self.kind = samples, kind


@dataclass(frozen=True)
class Step:
    """One step of the procedure.

    key: its name in the journal's events. kind: kind of the reading that it gives; "straight" or
    "done" if it gives none. say: instruction to the person. fields: numbers to be read.
    lambda_deg, incline_deg: the plan's bend and incline. settle_s: time to wait before reading.
    gait: the gait to be run. cells: columns of the reading that the plan determines.
    """

    key: str
    kind: str
    say: str
    fields: tuple[Field, ...] = ()
    lambda_deg: float = 0.0
    incline_deg: float = 0.0
    settle_s: float = 0.0
    gait: Gait | None = None
    cells: Values = field(default_factory=dict)

    @property
    def posed_deg(self) -> float | None:
        """Return the plan's bend in which the robot lies after the step, deg; None if unknown."""
        is_posed = self.kind in ("straight", "bend", "station", "push")
        return self.lambda_deg if is_posed else None


def record_step(record: Journal, step: Step, cells: Cells) -> int:
    """Write the reading of a step to the journal; return its number, 0 if the step has none."""
    if step.kind == "straight":
        return 0
    reading = cells if isinstance(cells, Tracked) else Tracked(cells)
    kind = reading.kind or step.kind
    values = KINDS[kind].derived(step.cells | reading, record.session.setup.instruments)
    return record.add(kind, values, samples=reading.samples)


def planned_bends(plan: Plan) -> tuple[float, ...]:
    """Return the bends of a plan, deg, straight included."""
    return plan.push_lambda_deg if plan.on == "floor" else plan.lambda_deg


def pose_key(plan: Plan, bend_deg: float) -> str:
    """Return the key, in the journal's events, of all readings in one bend."""
    pose = f"bend {bend_deg:g}" if bend_deg else "straight"
    return f"pushes, {pose}" if plan.on == "floor" else pose


def _nearest_bend(plan: Plan, lambda_rad: float) -> float:
    shown_deg = math.degrees(lambda_rad)
    return min(planned_bends(plan), key=lambda bend_deg: abs(bend_deg - shown_deg))


def taken_in(session: Session, bend_deg: float) -> list[Any]:
    """Return the kept readings in one of the plan's bends: stations, or pushes on a floor."""
    plan = session.setup.plan
    return [
        reading
        for reading in session.kept_of("push" if plan.on == "floor" else "station")
        if (reading.bend == plan.bend or not reading.lambda_rad)
        and _nearest_bend(plan, reading.lambda_rad) == bend_deg
    ]


def shown_bend(session: Session, bend_deg: float) -> float | None:
    """Return a bend as the last protractor check showed it, deg; None if that was another bend."""
    if not bend_deg:
        return 0.0
    plan, checks = session.setup.plan, session.kept_of("bend")
    if not checks or checks[-1].bend != plan.bend:
        return None
    found_rad: float = checks[-1].found_rad
    return math.degrees(found_rad) if _nearest_bend(plan, found_rad) == bend_deg else None


def friction_factor(bend_deg: float) -> float:
    """Return the rolling friction of a bent robot over a straight one's, as of the 2005 robot."""
    return 1.0 + 1.4 * math.radians(bend_deg)


def line_of(session: Session, bend_deg: float) -> tuple[float, float] | None:
    """Return slope and offset, m/s, of the line through a bend's stations.

    The line is the belt's speed past the robot as a function of sin(incline). None if there are
    fewer than two inclines, or if the line falls.
    """
    stations = taken_in(session, bend_deg)
    sines = [math.sin(station.incline_rad) for station in stations]
    same_sine = 1e-4  # Range of the sines below which no line is fitted.
    if not sines or np.ptp(sines) < same_sine:
        return None
    slope, offset_m_s = np.polyfit(sines, [station.slip_speed_m_s for station in stations], 1)
    return (float(slope), float(offset_m_s)) if slope > 0.0 else None
