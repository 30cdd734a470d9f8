"""The lab's crawling robot at each 1/1200 s, driven by servos on frames of 20 ms."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import serpenoid as sn
from serpenoid import _core
from serpenoid.lab.floor import Floor
from serpenoid.lab.robot import LabRobot

TICKS = 24  # in a frame of 20 ms; 5 in a picture of 240 a second
TICK_S = 0.02 / TICKS


@dataclass(frozen=True)
class Motion:
    """Times (T,), the middle of the body (T,) as complex m, headings of all links (T, n)."""

    t_s: np.ndarray
    middle_m: np.ndarray
    theta_rad: np.ndarray

    @property
    def joints_rad(self) -> np.ndarray:
        """Return the joints' angles, (T, n-1)."""
        return np.diff(self.theta_rad, axis=1)


def driven(
    robot: sn.Robot, whole: sn.Ground, gait: sn.Gait, servo: sn.Servo, seconds: float, skip_s: float
) -> Motion:
    """Return `seconds` of a run after skip_s of settling; set-points are the firmware's own."""
    joints = robot.links - 1
    told = _core.firmware.gait_setpoints_rad(
        gait.alpha_rad,
        gait.beta_rad,
        gait.omega_rad_s,
        joints=joints,
        frames=round((skip_s + seconds) / 0.02),
    )
    lab = LabRobot.whole(robot, whole, servo=replace(servo, frame_s=TICK_S))
    track, phi = Floor(lab).run_servos(np.repeat(np.array(told), TICKS, axis=0))
    bend = np.concatenate([np.zeros((len(phi), 1)), np.cumsum(phi, axis=1)], axis=1)
    theta = track.heading_rad[:, None] + bend - bend.mean(axis=1, keepdims=True)
    late = track.t_s > skip_s
    return Motion(track.t_s[late] - skip_s, (track.x_m + 1j * track.y_m)[late], theta[late])
