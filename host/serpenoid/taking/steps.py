"""One step of a session: what to set, in a few words, and which numbers to type then."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from ..model.gait import Gait
from ..session.declaration import READ, Cells, Field, Range, Values
from ..session.track import Samples

if TYPE_CHECKING:
    from .expected import Series

Doubts = list[tuple[Field, Range]]  # numbers that are not where they were expected


class Tracked(dict[str, "float | str"]):
    """Cells of a reading with the samples of its track; kind: where it is not that of the step."""

    def __init__(self, cells: Cells, samples: Samples, kind: str = ""):
        super().__init__(cells)
        self.samples, self.kind = samples, kind


@dataclass(frozen=True)
class Step:
    """One step: `key` names it in events, `say` tells what to set, `fields` what to type.

    kind: that of the reading it ends in; else straight or done. lambda_deg: the bend it belongs to.
    bend: of a bent robot, balanced or zigzag. settle_s:
    how long to wait before reading. gait: to be run. cells: what the plan tells of the reading.
    series: that it is of, whose pose it needs.
    """

    key: str
    kind: str
    say: str
    fields: tuple[Field, ...] = ()
    lambda_deg: float = 0.0
    incline_deg: float = 0.0
    settle_s: float = 0.0
    gait: Gait | None = None
    bend: str = "zigzag"
    cells: Values = field(default_factory=dict)
    series: Series | None = None

    @property
    def asked(self) -> tuple[Field, ...]:
        """Return the fields that a person is asked for."""
        return tuple(field for field in self.fields if field.source == READ)
