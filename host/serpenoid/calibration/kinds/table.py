"""All kinds of readings by their names, in the order of a session's sheet."""

from __future__ import annotations

from .belt import BELT
from .bend import BEND
from .coast import COAST
from .declaration import Kind
from .gait import GAIT
from .slide import BREAKAWAY, SLIDE
from .station import STATION
from .video import VIDEO
from .zero import ZERO

KINDS: dict[str, Kind] = {
    kind.name: kind for kind in (STATION, BEND, ZERO, BELT, GAIT, VIDEO, COAST, SLIDE, BREAKAWAY)
}
