"""The host's end of the wire to the board; see firmware/PROTOCOL.md."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .robot import RobotBoard

__all__ = ["RobotBoard"]


def __getattr__(name: str) -> Any:
    """Import the class when it is first used: the command line's help does without."""
    if name != "RobotBoard":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from .robot import RobotBoard

    return RobotBoard
