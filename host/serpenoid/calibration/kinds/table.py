"""All kinds of readings by their names, in the order of a session's sheet."""

from __future__ import annotations

from .belt import BELT, BeltCheck
from .bend import BEND, BendCheck
from .coast import COAST, Coast
from .declaration import Kind
from .gait import GAIT, GaitRun
from .slide import BREAKAWAY, SLIDE, BreakAway, Slide
from .station import STATION, Reading
from .video import VIDEO, FilmReading
from .zero import ZERO, ZeroReading

KINDS: dict[str, Kind] = {
    kind.name: kind for kind in (STATION, BEND, ZERO, BELT, GAIT, VIDEO, COAST, SLIDE, BREAKAWAY)
}
AnyReading = (
    Reading
    | BendCheck
    | ZeroReading
    | BeltCheck
    | GaitRun
    | FilmReading
    | Coast
    | Slide
    | BreakAway
)
