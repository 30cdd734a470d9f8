"""The host's end of the wire to the board; see firmware/PROTOCOL.md."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .robot import Robot, RobotBoard

__all__ = ["Robot", "RobotBoard"]


def __getattr__(name: str) -> Any:
    """Import the class when it is first used: the command line's help does without."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from .robot import RobotBoard

    globals().update(dict.fromkeys(__all__, RobotBoard))
    return RobotBoard
