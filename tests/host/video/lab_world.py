"""A lab robot before the camera: the firmware's set-points, servos, wheels on a floor, and a pose.

The virtual board runs the firmware's controller; each joint has a servo with faults of its own;
the lab's floor moves the body. What is true is taken from the lab's own rows, over whole cycles.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import serpenoid as sn
from serpenoid.lab.floor import Floor
from serpenoid.lab.robot import LabRobot
from serpenoid.robot import RobotBoard as Board
from video.worlds import LINK_M, World

FRAME_S, STEP_S = 0.02, 0.002  # of the board's set-points, of the joints' rows
SETTLED_S = 4.0  # the board has blended into the gait, the body has no start left


@dataclass(frozen=True)
class Servos:
    """How joints follow set-points: lag_s of a first-order loop, limited rate, linkage's gain."""

    lag_s: np.ndarray
    gain: np.ndarray
    rate_rad_s: float = 6.0

    def angles(self, set_rad: np.ndarray) -> np.ndarray:
        """Return the joints' angles each STEP_S, from rows of set-points each FRAME_S."""
        wanted = np.repeat(set_rad, round(FRAME_S / STEP_S), axis=0)
        phi, rows = wanted[0].copy(), []
        for row in wanted:
            rate = np.clip((row - phi) / self.lag_s, -self.rate_rad_s, self.rate_rad_s)
            phi = phi + STEP_S * rate
            rows.append(phi)
        return np.array(rows) * self.gain


def set_points(gait: sn.Gait, seconds: float, record: Path | None = None) -> np.ndarray:
    """Return what the firmware in the virtual board asks of its servos, a row each frame."""
    with Board("virtual:fast", record=record) as board:
        board.gait(gait)
        return np.array([frame.setpoint_rad for frame in board.frames(seconds)])


def crawled(robot: LabRobot, servos: Servos, gait: sn.Gait, set_rad: np.ndarray) -> World:
    """Return the robot's poses from SETTLED_S on, and what is true of them."""
    joints = servos.angles(set_rad) + np.array(robot.joint_error_rad)
    track, phi = Floor(robot).follow(joints, STEP_S)
    skip = round(SETTLED_S / STEP_S)
    phi = phi[skip:]
    t = track.t_s[skip:] - track.t_s[skip]
    middle = (track.x_m + 1j * track.y_m)[skip:]
    heading = np.unwrap(track.heading_rad[skip:])
    bend = np.concatenate([np.zeros((len(phi), 1)), np.cumsum(phi, axis=1)], axis=1)
    theta = heading[:, None] + bend - bend.mean(axis=1, keepdims=True)
    half = LINK_M / 2 * np.exp(1j * theta)
    steps = half[:, :-1] + half[:, 1:]
    centre = np.concatenate([np.zeros((len(phi), 1)), np.cumsum(steps, axis=1)], axis=1)
    centre += middle[:, None] - centre.mean(axis=1, keepdims=True)
    cycle = round(gait.period_s / STEP_S)
    cycles = (len(t) - 1) // cycle
    wave = np.exp(-1j * gait.omega_rad_s * t[: cycles * cycle])
    first = 2j * np.mean(phi[: cycles * cycle] * wave[:, None], axis=0)  # a sine: A e^(i phase)
    ends = np.arange(cycles + 1) * cycle
    turn = (heading[ends[-1]] - heading[0]) / t[ends[-1]]
    arc = np.sinc(turn * t[cycle] / math.tau)  # chord over arc of a cycle
    chord = np.abs(np.diff(middle[ends])).mean()

    columns = np.column_stack([centre.real, centre.imag, theta])

    def pose(at_s: float) -> tuple[np.ndarray, np.ndarray]:
        row = np.array([np.interp(at_s, t, column) for column in columns.T])
        x, y, angle = np.split(row, 3)
        return np.column_stack([x, y]), angle

    return World(
        pose,
        robot.body.links,
        gait.omega_rad_s,
        np.abs(first),
        np.angle(first),
        phi[: cycles * cycle].mean(axis=0),
        float(chord / arc / t[cycle]),
        float(turn),
    )
