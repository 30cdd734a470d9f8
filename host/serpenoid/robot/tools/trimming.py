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
        self._warned = False
        self._show = show

    def go(self, lines: Iterable[str]) -> None:
        """Obey lines until one says to leave, or they end."""
        for trim in self.trims:
            self._tell(trim)
        self._show(HELP)
        for line in lines:
            if not self.obey(line.split()):
                break

    def obey(self, words: list[str]) -> bool:
        """Obey one line; return False to leave. Raises what RobotBoard raises, refusals apart."""
        warned, self._warned = self._warned, False
        if words == ["save"]:
            self.robot.save()
            self.unsaved = False
            self._show("saved on the board")
        elif words == ["quit"]:
            if warned or not self.unsaved:
                return False
            self._warned = True
            self._show("not saved: `save`, or `quit` once more")
        elif (typed := self._typed(words)) is None:
            self._show(HELP)
        else:
            self._centre(*typed)
        return True

    def _typed(self, words: list[str]) -> tuple[int, float] | None:
        """Return the joint's place in the list and its new centre (us); None if it is no such."""
        if len(words) != 2 or not words[0].isdecimal():
            return None
        joint = int(words[0]) - 1
        try:
            pulse_us = float(words[1])
        except ValueError:
            return None
        if not 0 <= joint < len(self.trims):
            return None
        relative = words[1][0] in "+-"
        return joint, pulse_us + (self.trims[joint].centre_us if relative else 0.0)

    def _centre(self, joint: int, centre_us: float) -> None:
        trim = self.trims[joint]
        try:
            self.robot.trim(trim.joint, "centre", centre_us)
        except CommandRefused as error:
            self._show(str(error))
            return
        self.trims[joint] = replace(trim, centre_us=centre_us)
        self.unsaved = True
        self._tell(self.trims[joint])

    def _tell(self, trim: Trim) -> None:
        self._show(f"joint {trim.joint}  centre {trim.centre_us:g} us")


def straighten(robot: RobotBoard) -> None:
    """Move all joints to 0 and wait until they are there."""
    robot.straight()
    robot.settle()
