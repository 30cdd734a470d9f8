"""The host's end of the wire to the board; see firmware/PROTOCOL.md."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .robot import Robot

__all__ = ["Robot"]


def __getattr__(name: str) -> Any:
    """Import Robot when it is first asked for: the command line's help does without."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from .robot import Robot

    globals()["Robot"] = Robot
    return Robot
