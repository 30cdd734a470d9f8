"""A robot let go on a tilted, moving belt: it rolls, yaws, drifts, and leaves the belt."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .robot import LabRobot, check_answer


@dataclass(frozen=True, slots=True)
class Sight:
    """Position and heading of a robot at a time.

    t_s: time, s. along_m, across_m: distance from the belt's middle, downhill and to the left, m.
    heading_rad: direction from tail to head, 0 downhill.
    """

    t_s: float
    along_m: float
    across_m: float
    heading_rad: float


class Belt:
    """Hold a treadmill and the robot on it. The frame is the room's, x downhill along the belt.

    speed_m_s: the belt's present speed, uphill. pose_rad: commanded joint angles without the
    steering offset.
    """

    def __init__(self, robot: LabRobot, *, gravity_m_s2: float = 9.81):
        self.robot = robot
        self.t_s = 0.0
        self._chain, self._gravity = robot.chain(), gravity_m_s2
        self.pose_rad, self._offset = [0.0] * (robot.body.links - 1), 0.0
        self.speed_m_s, self._wanted_m_s = 0.0, 0.0

    def tilt(self, incline_rad: float) -> None:
        """Raise the belt to an incline."""
        self._chain.set_slope(self._gravity * math.sin(incline_rad), 0.0)

    def run(self, speed_m_s: float) -> None:
        """Set the wanted speed of the belt, uphill; `wait` lets the belt approach it."""
        self._wanted_m_s = speed_m_s

    def pose(self, set_rad: Sequence[float]) -> None:
        """Bend the robot off the belt. set_rad: commanded joint angles."""
        self.pose_rad, self._offset = list(set_rad), 0.0
        self._chain.set_joints(self._joints())

    def steer(self, offset_rad: float) -> None:
        """Add an offset to every joint on the belt; joints turn at the rate that a board uses."""
        self._offset = offset_rad
        self._chain.aim(self._joints(), math.radians(2.0))

    def put(
        self,
        across_m: float = 0.0,
        heading_rad: float = 0.0,
        push_m_s: float = 0.0,
        push_rad_s: float = 0.0,
    ) -> None:
        """Place the robot on the belt and let it go, at rest in the room but for a push."""
        self.speed_m_s = self._wanted_m_s
        chain = self._chain
        chain.set_ground_velocity(-self.speed_m_s, 0.0)
        chain.set_joints(self._joints())
        chain.place(0.0, across_m, 0.0, 0.0, 0.0, 0.0)
        chain.place(0.0, across_m, heading_rad - self._heading_rad(), push_m_s, 0.0, push_rad_s)

    def wait(self, duration_s: float) -> None:
        """Let time pass; the belt's speed changes by at most 0.25 m/s². Raises NotConverged."""
        remaining_s, rounding_s = duration_s, 1e-9
        while remaining_s > rounding_s:
            dt = min(remaining_s, 0.1) if self.speed_m_s != self._wanted_m_s else remaining_s
            change = 0.25 * dt
            self.speed_m_s += min(max(self._wanted_m_s - self.speed_m_s, -change), change)
            self._chain.set_ground_velocity(-self.speed_m_s, 0.0)
            # With ten times shorter steps, a zigzag turns 0.005 deg less in 6 s.
            check_answer(self._chain.advance(dt, 0.004))
            self.t_s += dt
            remaining_s -= dt

    def look(self) -> Sight:
        """Return where the robot is."""
        x, y, *_ = self._chain.state
        return Sight(self.t_s, x, y, self._heading_rad())

    def _heading_rad(self) -> float:
        """Return the direction from the tail's end to the head's end."""
        angles = np.reshape(self._chain.places, (-1, 3))[:, 2]
        return math.atan2(np.sin(angles).sum(), np.cos(angles).sum())

    def _joints(self) -> list[float]:
        return self.robot.true_joints([a + self._offset for a in self.pose_rad])
