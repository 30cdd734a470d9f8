"""Centre the servos by keys, on a robot that holds itself straight."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from ...base.errors import CommandRefused
from ..robot import RobotBoard
from .keys import Keyboard

HELP = """\
left, right or a digit: joint (1 at the tail)   up, down or +, -: 1 us   page up, page down: 10 us
s: save on the board   q: leave"""
MOVES = {"up": 1, "+": 1, "down": -1, "-": -1, "page up": 10, "page down": -10}
TURNS = {"left": -1, "right": 1}
WAIT_S = 0.5
UNATTENDED_S = 3600.0  # the robot holds still while a person looks for a screwdriver


class Trimming:
    """The keys' meaning: which joint is chosen, what is changed, what is not saved yet."""

    def __init__(self, robot: RobotBoard, show: Callable[[str], None]):
        self.robot = robot
        self.trims = list(robot.trims())
        self.chosen = 0
        self.unsaved = False
        self._warned = False
        self._show = show

    def go(self, keyboard: Keyboard) -> None:
        """Obey keys until one says to leave."""
        self._show(HELP)
        self._tell(self.chosen)
        while self.press(keyboard(WAIT_S)):
            pass

    def press(self, key: str) -> bool:
        """Obey one key; return False to leave. Raises what RobotBoard raises, refusals apart."""
        warned, self._warned = self._warned, self._warned and not key
        if key in MOVES:
            self._move(MOVES[key])
        elif key in TURNS:
            self._tell((self.chosen + TURNS[key]) % len(self.trims))
        elif key in map(str, range(1, len(self.trims) + 1)):
            self._tell(int(key) - 1)
        elif key == "s":
            self.robot.save()
            self.unsaved = False
            self._show("saved on the board")
        elif key in ("q", "end"):
            return self._stay(warned or key == "end")
        return True

    def _move(self, change_us: int) -> None:
        trim = self.trims[self.chosen]
        centre_us = trim.centre_us + change_us
        try:
            self.robot.trim(trim.joint, "centre", centre_us)
        except CommandRefused as error:
            self._show(str(error))
            return
        self.trims[self.chosen] = replace(trim, centre_us=centre_us)
        self.unsaved = True
        self._tell(self.chosen)

    def _tell(self, joint: int) -> None:
        self.chosen = joint
        trim = self.trims[joint]
        saved = "  (not saved)" if self.unsaved else ""
        self._show(f"joint {trim.joint}  centre {trim.centre_us:g} us{saved}")

    def _stay(self, sure: bool) -> bool:
        """Return whether to stay: once, if something is not saved."""
        if sure or not self.unsaved:
            return False
        self._warned = True
        self._show("not saved: s saves, q once more leaves")
        return True


def straighten(robot: RobotBoard) -> None:
    """Move all joints to 0 and wait until they are there."""
    robot.straight()
    robot.settle()
