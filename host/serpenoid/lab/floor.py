"""A robot on a floor: pushed and let roll, or driven to crawl."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .._core import LabChain
from ..base.vectors import Array
from ..model.gait import Gait
from .robot import LabRobot, check_answer

STEP_S = 0.001  # Step of the motion without servos.
REACH_M = 0.15  # Reach of a hand that pushes.
FRAME_S = 0.01  # Time between the rows of a track.


@dataclass(frozen=True)
class Track:
    """Where a robot truly was: t_s (T,), s; x_m, y_m of its centre, m; heading_rad of its axis.

    released_s: when the hand let go of it, s; 0 where none touched it.
    """

    t_s: Array
    x_m: Array
    y_m: Array
    heading_rad: Array
    released_s: float = 0.0


@dataclass(frozen=True)
class Push:
    """How a hand pushes over REACH_M.

    speed_m_s: speed at release. direction_rad: direction of the push in the room; add pi for the
    way back. heading_rad: heading relative to the push. rate_rad_s: rate of turn at release.
    """

    speed_m_s: float
    direction_rad: float = 0.0
    heading_rad: float = 0.0
    rate_rad_s: float = 0.0


class Floor:
    """Hold a floor that falls by slope_rad towards the room's x, and by across_rad to its left."""

    def __init__(self, robot: LabRobot, slope_rad: float = 0.0, across_rad: float = 0.0):
        self.robot = robot
        self._pull = 9.81 * math.sin(slope_rad), 9.81 * math.sin(across_rad)

    def push(self, pose_rad: Sequence[float], push: Push) -> Track:
        """Push the robot, let it go, and follow it until it rests."""
        hand_s = 2 * REACH_M / push.speed_m_s
        heading = push.direction_rad + push.heading_rad
        c, s = math.cos(push.direction_rad), math.sin(push.direction_rad)
        t = np.arange(0.0, hand_s, FRAME_S)
        along_m = 0.5 * push.speed_m_s / hand_s * t**2 - REACH_M
        hand_rows = np.stack([t, c * along_m, s * along_m, np.full_like(t, heading)], axis=1)
        rates = c * push.speed_m_s, s * push.speed_m_s, push.rate_rad_s
        joints = self.robot.true_joints(pose_rad)
        chain = self._placed(self.robot.chain(), joints, heading, rates)
        bend, free_rows = _mean_bend(joints), []
        rest_m_s, rest_rad_s = 1e-6, 1e-5
        for k in range(6000):  # a minute at most
            x, y, theta, vx, vy, w, _ = chain.state
            free_rows.append((k * FRAME_S + hand_s, x, y, theta + bend))
            if k and math.hypot(vx, vy) < rest_m_s and abs(w) < rest_rad_s:
                break
            check_answer(chain.advance(FRAME_S, STEP_S))
        return Track(*np.concatenate([hand_rows, free_rows]).T, released_s=hand_s)

    def driven(self, gait: Gait, duration_s: float, frame_s: float) -> tuple[Track, Array]:
        """Return the track and the true joint angles of a robot that runs a gait from rest.

        Servos get a setpoint in each of their own frames; without servos, frame_s is the frame.
        """
        servo, joints = self.robot.servo, np.arange(self.robot.body.links - 1)
        frame_s = servo.frame_s if servo else frame_s
        phase = gait.omega_rad_s * frame_s * np.arange(round(duration_s / frame_s) + 1)[:, None]
        swing = gait.alpha_rad * np.sin(phase + joints * gait.beta_rad) + gait.offset_rad
        return self.follow(swing + np.array(self.robot.joint_error_rad), frame_s)

    def follow(self, setpoints_rad: Array, frame_s: float) -> tuple[Track, Array]:
        """Return the track and the true joint angles at the end of each frame.

        setpoints_rad: (K, n-1), a row for each frame; the robot starts from rest at the first row.
        Without servos the joints move at a constant rate from one row to the next.
        """
        servo = self.robot.servo
        chain = self._placed(self.robot.chain(servo), setpoints_rad[0].tolist())
        # This step makes speeds with a servo some 0.2 % wrong, 3 % if the servo has no rotor.
        step_s = 5e-4 if servo else STEP_S
        rows = chain.follow(np.ascontiguousarray(setpoints_rad), frame_s, step_s)
        check_answer(len(rows) == len(setpoints_rad) and bool(np.isfinite(rows).all()))
        t, angles = np.arange(1.0, len(rows) + 1) * frame_s, rows[:, 2:]
        return Track(t, rows[:, 0], rows[:, 1], angles.mean(axis=1)), np.diff(angles, axis=1)

    def _placed(
        self,
        chain: LabChain,
        joints: list[float],
        heading_rad: float = 0.0,
        rates: tuple[float, float, float] = (0.0, 0.0, 0.0),
    ) -> LabChain:
        chain.set_joints(joints)
        chain.set_slope(*self._pull)
        chain.place(0.0, 0.0, heading_rad - _mean_bend(joints), *rates)
        return chain


def _mean_bend(joints: Sequence[float]) -> float:
    """Return the mean of the links' angles relative to link 1, rad."""
    return float(np.cumsum(joints).sum()) / (len(joints) + 1)
