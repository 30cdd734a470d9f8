"""What servos do once their pulses end: asked of a person once, kept on the board."""

from __future__ import annotations

from collections.abc import Callable

from ..robot import RobotBoard
from ..wire.link import Link
from .trimming import UNATTENDED_S, straighten

RELEASED = {  # the board's setting of that name
    0.0: "nobody has tried whether these servos go limp when pulses end",
    1.0: "these servos go limp when pulses end",
    2.0: "these servos hold when pulses end: only the switch stops them",
}
FREE = "Has the robot free space all around, and is the switch within reach of your hand?"


def limp_test(port: str | Link | None, ask: Callable[[str], bool]) -> str | None:
    """Return what the servos do, kept in the board's setting `released`; None if not tried.

    ask: puts a question to the person at the robot, who answers yes or no.
    """
    if not ask(FREE):
        return None
    with RobotBoard(port, unattended_s=UNATTENDED_S) as robot:
        straighten(robot)
        robot.idle()
        turns = ask(
            "No pulses come now. Take one servo with its horn on that is linked to no other. Can "
            "you turn its horn by hand?"
        )
        released = 1.0 if turns else 2.0
        robot.set("released", released)
        robot.save()
    return RELEASED[released]
