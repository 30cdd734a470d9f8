"""All kinds of readings by their names, in the order of a session's sheet."""

from __future__ import annotations

from types import MappingProxyType

from .bend import BEND, BendCheck
from .gait import GAIT, GaitRun
from .station import STATION, Reading
from .zero import ZERO, ZeroReading

KINDS = MappingProxyType({kind.name: kind for kind in (STATION, BEND, ZERO, GAIT)})
AnyReading = Reading | BendCheck | ZeroReading | GaitRun
