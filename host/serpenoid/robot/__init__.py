"""The host's end of the wire to the board; see firmware/PROTOCOL.md."""

from .robot import RobotBoard

__all__ = ["RobotBoard"]
