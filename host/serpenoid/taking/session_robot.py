"""The robot of a session: bent as a step says, idle whenever nobody is there to see it."""

from __future__ import annotations

import math
from contextlib import ExitStack

from ..base.errors import CommandRefused, RobotError
from ..model.bends import bend_signs, joint_multiples
from ..model.gait import Gait
from ..robot.robot import RobotBoard
from ..robot.tools.limp_test import RELEASED
from ..robot.wire.link import Link

# Joints that jump shake wheels loose which would rest: in the lab, steering at 45 deg/s takes a
# quarter of its standard deviation off fn0.
STEER_DEG_S, POSE_DEG_S = 2.0, 45.0


class SessionRobot:
    """Hold one open robot. Joints move only in pose() and go(); `powered` tells whether they hold.

    Inside `with SessionRobot(port) as robot:` only. joints: how many the robot must have, None if
    any number will do. Raises what RobotBoard raises.
    """

    def __init__(self, port: str | Link | None, joints: int | None = None):
        self._robot = RobotBoard(port, joints=joints, unattended_s=6 * 3600.0)
        self.powered = False
        self.stopped = False  # True once a key stopped it and no prompt has seen it yet
        self.offset_rad = 0.0  # on every joint, to steer
        self._posed: tuple[float, str] | None = None
        self._pose_deg_s = POSE_DEG_S  # the board's own
        self._released = 0.0  # the board's setting

    def __enter__(self) -> SessionRobot:
        with ExitStack() as opened:
            robot = opened.enter_context(self._robot)
            settings = robot.settings()
            self._released = settings["released"]
            if not settings["limp"]:  # after a kill nothing else would let go of the bend
                robot.set("limp", 30.0)
            if not settings["silence"]:
                robot.set("silence", 2.0)
            if settings["pose_speed"] > STEER_DEG_S:  # else it was left so by a kill
                self._pose_deg_s = settings["pose_speed"]
            robot.set("pose_speed", self._pose_deg_s)
            opened.pop_all()
        return self

    def __exit__(self, *error: object) -> None:
        self.powered = False
        self._robot.__exit__(*error)  # type: ignore[arg-type]

    @property
    def greeting(self) -> str:
        """Return board and firmware in words."""
        hello = self._robot.hello
        return f"{hello.board}, firmware {hello.firmware}, protocol {hello.protocol}"

    @property
    def without_pulses(self) -> str:
        """Return in words what the servos do once idle() has ended their pulses."""
        limp = 1.0  # value of the board's setting of servos that were seen to go limp
        is_limp = self._released == limp
        return "servos off" if is_limp else f"pulses off ({RELEASED[self._released]})"

    def pose(self, bend_deg: float, bend: str = "balanced") -> None:
        """Bend the robot, balanced or as a zigzag; straight at 0."""
        self.powered = True
        self._quick()
        self._lie(bend_deg, bend, self.offset_rad)
        self._posed = bend_deg, bend
        self._robot.settle()
        self._robot.set("pose_speed", STEER_DEG_S)

    def _quick(self) -> None:
        """Give the board its own speed back, steering done."""
        if self._posed is not None:
            self._robot.set("pose_speed", self._pose_deg_s)

    def _lie(self, bend_deg: float, bend: str, offset_rad: float) -> None:
        multiples = joint_multiples(bend_signs(bend, self._robot.hello.joints + 1))
        self._robot.pose([offset_rad + k * math.radians(bend_deg) for k in multiples])

    def steer(self, steps: int) -> str:
        """Add steps to every joint of a robot that holds a pose; return the offset in words.

        Positive turns it to the left. A pose that a joint cannot reach is left as it was.
        """
        if self.powered and self._posed is not None:
            wanted_rad = self.offset_rad + steps * math.radians(0.25)
            try:
                self._lie(*self._posed, wanted_rad)
            except CommandRefused as error:
                return f"not steered: {error}"
            self.offset_rad = wanted_rad
        return f"{math.degrees(self.offset_rad):+.2f} deg on every joint"

    def go(self, gait: Gait) -> None:
        """Start a gait."""
        self.powered = True
        self._quick()
        self._posed = None
        self._robot.gait(gait)

    def stop(self) -> str:
        """Stop now, joints held until a prompt lets them go; return that in words.

        Nothing is to be stopped of a robot whose servos are off.
        """
        if not self.powered:
            return "the servos are off"
        self.stopped = True
        self._robot.stop()
        return "stopped"

    def idle(self) -> None:
        """Stop, and let the servos go limp."""
        if self.powered:
            self._robot.idle()
            self.powered = False
            self._quick()
        self._posed, self.stopped = None, False

    def tick(self) -> None:
        """Show that the program is alive; raises RobotLost and the like when the robot is not."""
        self._robot.status()

    def rate(self, gait: Gait) -> float:
        """Return the gait's true rate by the board's clock, rad/s; nominal where that is unsure."""
        try:
            rate, sd = self._robot.clock.true_rate(gait.omega_rad_s)
        except RobotError:
            return gait.omega_rad_s
        return rate if sd < 0.002 * rate else gait.omega_rad_s
