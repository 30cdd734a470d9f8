"""Poses of a robot for rendered films: firmware, imperfect servos, and the floor of the lab.

The virtual board gives the setpoints, servos with lag and gain move the joints, and the lab's floor
moves the body. The true values are computed from the simulated rows, over whole cycles.
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

FRAME_S, STEP_S = 0.02, 0.002  # intervals of the board's setpoints, and of the joints' rows
SETTLED_S = 4.0  # time after which the gait and the motion of the body have settled


@dataclass(frozen=True)
class Servos:
    """Servos: time constant of a first-order loop, greatest rate, and gain of the linkage."""

    lag_s: np.ndarray
    gain: np.ndarray
    rate_rad_s: float = 6.0

    def angles(self, setpoint_rad: np.ndarray) -> np.ndarray:
        """Return the angles of the joints every STEP_S, rad, from setpoints every FRAME_S."""
        goals = np.repeat(setpoint_rad, round(FRAME_S / STEP_S), axis=0)
        phi, rows = goals[0].copy(), []
        for goal in goals:
            rate = np.clip((goal - phi) / self.lag_s, -self.rate_rad_s, self.rate_rad_s)
            phi = phi + STEP_S * rate
            rows.append(phi)
        return np.array(rows) * self.gain


def setpoints(gait: sn.Gait, seconds: float, record: Path | None = None) -> np.ndarray:
    """Return the setpoints of the virtual board, rad, one row for each frame."""
    with Board("virtual:fast", record=record) as board:
        board.gait(gait)
        return np.array([frame.setpoint_rad for frame in board.frames(seconds)])


def simulated_world(
    robot: LabRobot, servos: Servos, gait: sn.Gait, setpoint_rad: np.ndarray
) -> World:
    """Return the poses of the robot from SETTLED_S on, with the true values."""
    joints = servos.angles(setpoint_rad) + np.array(robot.joint_error_rad)
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
    mode = 2j * np.mean(phi[: cycles * cycle] * wave[:, None], axis=0)  # A exp(i phase) of a sine
    ends = np.arange(cycles + 1) * cycle
    turn = (heading[ends[-1]] - heading[0]) / t[ends[-1]]
    chord_over_arc = np.sinc(turn * t[cycle] / math.tau)  # of the path in a cycle
    chord = np.abs(np.diff(middle[ends])).mean()

    columns = np.column_stack([centre.real, centre.imag, theta])

    def pose(t_s: float) -> tuple[np.ndarray, np.ndarray]:
        row = np.array([np.interp(t_s, t, column) for column in columns.T])
        x, y, angle = np.split(row, 3)
        return np.column_stack([x, y]), angle

    return World(
        pose,
        robot.body.links,
        gait.omega_rad_s,
        np.abs(mode),
        np.angle(mode),
        phi[: cycles * cycle].mean(axis=0),
        float(chord / chord_over_arc / t[cycle]),
        float(turn),
    )
