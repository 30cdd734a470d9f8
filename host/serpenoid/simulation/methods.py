"""Every method and what it runs, read from the core's registry."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from .. import _core


@dataclass(frozen=True, slots=True)
class MethodKind:
    """Say which scenes a method runs; a row of host/core/scene/method_table.hpp.

    order: of convergence at recorded times, for smooth motion. adaptive: formulations in which it
    takes steps of its own to scene.tolerance; in the others steps of dt_s. faults: whether it runs
    with limp or locked joints.
    """

    order: int
    formulations: tuple[str, ...]
    adaptive: tuple[str, ...]
    laws: tuple[str, ...]
    faults: bool


_WORDS = ("formulations", "adaptive", "laws")


def _kind(row: dict[str, Any]) -> MethodKind:
    words: dict[str, Any] = {name: tuple(row[name].split()) for name in _WORDS}
    return MethodKind(**{**row, **words})


METHODS = {row.pop("name"): _kind(row) for row in _core.method_table()}


class OwnChoice(str):
    """Hold a method's name that a scene chose by itself: changed, the scene chooses anew."""

    __slots__ = ()
