"""The robot of a session: it is bent and steered, and goes limp whenever nobody watches it."""

from __future__ import annotations

import math
from contextlib import ExitStack

from ..base.errors import CommandRefused, RobotError
from ..model.bends import bend_signs, joint_multiples
from ..model.gait import Gait
from ..robot.robot import RobotBoard
from ..robot.tools.limp_test import RELEASED
from ..robot.wire.link import Link

# Speeds of the joints while steering, and while taking a pose. Fast steering shakes loose wheels
# that would stick: in the virtual lab, 45 deg/s lowers fn0 by a quarter of its standard deviation.
STEER_DEG_S, POSE_DEG_S = 2.0, 45.0


class SessionRobot:
    """One connected robot, used as `with SessionRobot(port) as robot:`.

    port: as of RobotBoard. joints: number of joints that the robot must have; None: any. Joints
    move only in pose(), steer() and run(). powered: whether the servos hold their angles. stopped:
    whether a key has stopped the robot since the last prompt. offset_rad: steering angle on every
    joint. Raises the errors of RobotBoard.
    """

    def __init__(self, port: str | Link | None, joints: int | None = None):
        self._robot = RobotBoard(port, joints=joints, unattended_s=6 * 3600.0)
        self.powered = False
        self.stopped = False
        self.offset_rad = 0.0
        self._posed: tuple[float, str] | None = None
        self._pose_deg_s = POSE_DEG_S  # The board's setting, replaced while steering.
        self._released = 0.0  # The board's setting: what servos do without pulses.

    def __enter__(self) -> SessionRobot:
        with ExitStack() as opened:
            robot = opened.enter_context(self._robot)
            settings = robot.settings()
            self._released = settings["released"]
            if not settings["limp"]:  # So the pose ends even if this program is killed.
                robot.set("limp", 30.0)
            if not settings["silence"]:
                robot.set("silence", 2.0)
            if settings["pose_speed"] > STEER_DEG_S:  # A killed program leaves a lower one.
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
        """Return in words the state of the servos after idle()."""
        limp = 1.0  # Value of `released` for servos that go limp without pulses.
        is_limp = self._released == limp
        return "servos off" if is_limp else f"pulses off ({RELEASED[self._released]})"

    def pose(self, bend_deg: float, bend: str = "balanced") -> None:
        """Bend the links by bend_deg, "balanced" or as a "zigzag", and wait until it is done."""
        self.powered = True
        self._restore_pose_speed()
        self._bend(bend_deg, bend, self.offset_rad)
        self._posed = bend_deg, bend
        self._robot.settle()
        self._robot.set("pose_speed", STEER_DEG_S)

    def _restore_pose_speed(self) -> None:
        """Restore the board's own speed after steering."""
        if self._posed is not None:
            self._robot.set("pose_speed", self._pose_deg_s)

    def _bend(self, bend_deg: float, bend: str, offset_rad: float) -> None:
        multiples = joint_multiples(bend_signs(bend, self._robot.hello.joints + 1))
        self._robot.pose([offset_rad + k * math.radians(bend_deg) for k in multiples])

    def steer(self, steps: int) -> str:
        """Add steps of 0.25 deg to every joint of a posed robot; return the offset in words.

        Positive steps turn it to the left. If a joint cannot reach its angle, nothing moves.
        """
        if self.powered and self._posed is not None:
            wanted_rad = self.offset_rad + steps * math.radians(0.25)
            try:
                self._bend(*self._posed, wanted_rad)
            except CommandRefused as error:
                return f"not steered: {error}"
            self.offset_rad = wanted_rad
        return f"{math.degrees(self.offset_rad):+.2f} deg on every joint"

    def run(self, gait: Gait) -> None:
        """Start a gait, steering and pose ended."""
        self.powered = True
        self._restore_pose_speed()
        self._posed = None
        self._robot.gait(gait)

    def stop(self) -> str:
        """Stop the gait and hold the joints until the next prompt; return the state in words."""
        if not self.powered:
            return "the servos are off"
        self.stopped = True
        self._robot.stop()
        return "stopped"

    def idle(self) -> None:
        """Stop the gait and let the servos go limp."""
        if self.powered:
            self._robot.idle()
            self.powered = False
            self._restore_pose_speed()
        self._posed, self.stopped = None, False

    def tick(self) -> None:
        """Tell the board that the program is alive; raises RobotLost or another RobotError."""
        self._robot.status()

    def rate(self, gait: Gait) -> float:
        """Return the gait's true rate by the board's clock, rad/s; the nominal one if uncertain."""
        try:
            rate, sigma = self._robot.clock.true_rate(gait.omega_rad_s)
        except RobotError:
            return gait.omega_rad_s
        return rate if sigma < 0.002 * rate else gait.omega_rad_s
