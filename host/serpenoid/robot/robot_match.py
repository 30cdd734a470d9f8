"""Which robot a session or gait belongs to: a board that moves other links is refused."""

from __future__ import annotations

from dataclasses import dataclass

from ..base.errors import BadInput
from .robot import RobotBoard


@dataclass(frozen=True)
class RobotMatch:
    """A number of links, what was made for a robot of so many, and what to do for another."""

    links: int
    what: str
    cure: str

    def check(self, robot: RobotBoard) -> None:
        """Raise BadInput, before anything moves, if the board moves other links."""
        moved = robot.hello.joints + 1
        if moved == self.links:
            return
        cure = self.cure
        if robot.hello.board == "virtual":
            cure += f"; or the virtual robot of that size: --port virtual:joints={self.links - 1}"
        raise BadInput(
            f"{self.what} is of a robot of {self.links} links, but this board moves {moved} "
            f"links; {cure}"
        )
