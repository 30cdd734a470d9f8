"""Centre the servos by typed numbers, on a robot that holds itself straight."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from ...base.errors import CommandRefused
from ..robot import RobotBoard
from ..wire.reports import Trim

HELP = "joint (1 at the tail) and pulse in us: `2 1510`, or `2 +10`; `save`, `quit`"
UNATTENDED_S = 3600.0  # the robot holds still while a person looks for a screwdriver


def trim_servos(robot: RobotBoard, lines: Iterable[str], show: Callable[[str], object]) -> None:
    """Obey typed lines until one says to leave, or they end; refusals are shown."""
    straighten(robot)
    unsaved = False
    for trim in robot.trims():
        show(centre_text(trim))
    show(HELP)
    for line in lines:
        words = line.split()
        if words == ["quit"]:
            break
        if words == ["save"]:
            robot.save()
            unsaved = False
            show("saved on the board")
            continue
        try:
            joint, centre = words
            trim = {str(trim.joint): trim for trim in robot.trims()}[joint]
            start_us = trim.centre_us if centre[0] in "+-" else 0.0
            robot.trim(trim.joint, "centre", start_us + float(centre))
        except (KeyError, ValueError):
            show(HELP)
        except CommandRefused as error:
            show(str(error))
        else:
            unsaved = True
            show(centre_text(robot.trims()[trim.joint - 1]))
    if unsaved:
        show("not saved: the board forgets the centres when its power goes")


def centre_text(trim: Trim) -> str:
    """Return a servo's centre in words."""
    return f"joint {trim.joint}  centre {trim.centre_us:g} us"


def straighten(robot: RobotBoard) -> None:
    """Move all joints to 0 and wait until they are there."""
    robot.straight()
    robot.settle()
