"""Centre the servos by typed numbers, on a robot that holds itself straight."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace

from ...base.errors import CommandRefused
from ..robot import RobotBoard
from ..wire.reports import Trim

HELP = "joint (1 at the tail) and pulse in us: `2 1510`, or `2 +10`; `save`, `quit`"
UNATTENDED_S = 3600.0  # the robot holds still while a person looks for a screwdriver


class Trimming:
    """The typed lines' meaning: which servo is centred where, and whether that is saved."""

    def __init__(self, robot: RobotBoard, show: Callable[[str], None]):
        self.robot = robot
        self.trims = list(robot.trims())
        self.unsaved = False
        self._show = show

    def obey_all(self, lines: Iterable[str]) -> None:
        """Obey lines until one says to leave, or they end."""
        for trim in self.trims:
            self._show(centre_text(trim))
        self._show(HELP)
        for line in lines:
            if line.strip() == "quit":
                break
            self.obey(line.split())
        if self.unsaved:
            self._show("not saved: the board forgets the centres when its power goes")

    def obey(self, words: list[str]) -> None:
        """Obey one line. Raises what RobotBoard raises, refusals apart."""
        if words == ["save"]:
            self.robot.save()
            self.unsaved = False
            self._show("saved on the board")
            return
        try:
            joint, centre = words
            trim = self.trims[range(1, len(self.trims) + 1).index(int(joint))]
            moved_us = trim.centre_us if centre[0] in "+-" else 0.0
            centre_us = moved_us + float(centre)
        except ValueError:
            self._show(HELP)
            return
        try:
            self.robot.trim(trim.joint, "centre", centre_us)
        except CommandRefused as error:
            self._show(str(error))
            return
        self.trims[trim.joint - 1] = replace(trim, centre_us=centre_us)
        self.unsaved = True
        self._show(centre_text(self.trims[trim.joint - 1]))


def centre_text(trim: Trim) -> str:
    """Return a servo's centre in words."""
    return f"joint {trim.joint}  centre {trim.centre_us:g} us"


def straighten(robot: RobotBoard) -> None:
    """Move all joints to 0 and wait until they are there."""
    robot.straight()
    robot.settle()
