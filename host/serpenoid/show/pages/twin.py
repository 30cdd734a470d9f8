"""The twin of a robot: a model chain on the ground, its joints led through told set-points."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...base.errors import NotConverged
from ...lab.robot import LabRobot
from ...model.ground import Ground
from ...model.robot import Robot
from ...video.fitting.chain import lever_matrix

Array = NDArray[np.float64]
STEP_S = 0.002  # of the chain: 0.1 % of a gait's speed, far below what a page shows
SHORTEST_S, LONGEST_S = 1e-3, 10.0  # between two set-points; beyond a longer gap nobody knows


@dataclass(frozen=True)
class Motion:
    """The links at N moments, (N, n) each: centres in m, angles in rad, velocities in m/s."""

    x_m: Array
    y_m: Array
    theta_rad: Array
    vx_m_s: Array
    vy_m_s: Array

    @property
    def slip_m_s(self) -> Array:
        """Return the wheels' speed across their links."""
        return self.vy_m_s * np.cos(self.theta_rad) - self.vx_m_s * np.sin(self.theta_rad)

    def along_x(self) -> Motion:
        """Return the motion turned so that its centre's way from start to end lies along x."""
        way = np.mean(self.x_m[-1] - self.x_m[0]) + 1j * np.mean(self.y_m[-1] - self.y_m[0])
        turn = np.conj(way) / abs(way) if abs(way) > 0 else 1.0
        place, velocity = turn * (self.x_m + 1j * self.y_m), turn * (self.vx_m_s + 1j * self.vy_m_s)
        angle = self.theta_rad + np.angle(turn)
        return Motion(place.real, place.imag, angle, velocity.real, velocity.imag)


class Twin:
    """A robot with ideal joints, at rest at first: its mean heading along x, at the origin.

    It goes where friction lets it go while its joints move from set-point to set-point; so it
    ramps, holds and changes its gait as the board does.
    """

    def __init__(self, robot: Robot, ground: Ground, setpoint_rad: Array):
        self._robot = robot
        self._chain = LabRobot(robot, (ground,)).chain()
        self._joints = np.array(setpoint_rad, dtype=np.float64)
        self._chain.set_joints(self._joints.tolist())
        heading = float(np.cumsum(self._joints).sum()) / robot.links
        self._chain.place(0.0, 0.0, -heading, 0.0, 0.0, 0.0)

    def follow(self, setpoint_rad: Array, lasts_s: Array, every: int = 1) -> Motion:
        """Lead the joints to set-points (N, n-1), each within a time (N,); where it then is.

        every: of so many moments the first is kept.
        """
        rows = np.ascontiguousarray(setpoint_rad, dtype=np.float64)
        lasts_s = np.clip(lasts_s, SHORTEST_S, LONGEST_S)
        states = []
        for k, duration_s in enumerate(lasts_s):
            state = self._chain.follow(rows[k : k + 1], float(duration_s), STEP_S)
            if len(state) == 0:
                raise NotConverged("the twin came to no answer; are robot and friction sensible?")
            if k % every == 0:
                states.append(state)
        rate = np.diff(rows, axis=0, prepend=self._joints[None]) / lasts_s[:, None]
        self._joints = rows[-1]
        return self._motion(np.concatenate(states), rows[::every], rate[::every])

    def _motion(self, states: Array, joint_rad: Array, joint_rad_s: Array) -> Motion:
        """Return all links from centre of mass and link 1, (N, 6), and the joints, (N, n-1)."""
        x, y, theta, vx, vy, turning = (states[:, [k]] for k in range(6))
        start = ((0, 0), (1, 0))
        angle = theta + np.cumsum(np.pad(joint_rad, start), axis=1)
        rate = turning + np.cumsum(np.pad(joint_rad_s, start), axis=1)
        levers = self._robot.link_length_m * lever_matrix(self._robot.links).T
        c, s = np.cos(angle), np.sin(angle)
        place = x + c @ levers, y + s @ levers
        return Motion(*place, angle, vx - s * rate @ levers, vy + c * rate @ levers)
