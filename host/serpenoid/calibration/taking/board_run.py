"""A gait run with the firmware's controller in the loop: what the board really sends its servos."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ...model.errors import BadInput
from ...model.gait import Gait
from ...robot.robot import RobotBoard

RAMP_S = 4.0  # in which a board ramps into a gait
PERIODS = 2


def board_gait(robot: RobotBoard, gait: Gait) -> Gait:
    """Drive a gait and return the one that the board's set-points describe, in true seconds.

    Amplitude and lag are those of the set-points' fundamental over whole periods of the board, so
    that the fixed-point arithmetic, the joints' limits and the clock are in them. The robot goes
    on moving. Raises BadInput where the frames do not hold the gait.
    """
    robot.gait(gait)
    frames = list(robot.frames(RAMP_S + (PERIODS + 0.2) * gait.period_s))
    ramp_frames = RAMP_S * 1e6 / robot.hello.frame_us
    settled = [f for f in frames if f.frame - frames[0].frame > ramp_frames]
    if len(settled) < 8 or settled[-1].state != "gait":
        raise BadInput("the board did not go into the gait; see `serpenoid doctor`")
    phase = np.unwrap([f.phase_rad for f in settled])
    kept = phase - phase[0] < 2 * math.pi * PERIODS
    angle = np.array([f.setpoint_rad for f in settled])[kept]
    alpha, lag = _fundamental(phase[kept], angle)
    return Gait(alpha, lag, robot.true_rate_rad_s(gait.omega_rad_s)[0])


def _fundamental(phase: NDArray[np.float64], angle: NDArray[np.float64]) -> tuple[float, float]:
    """Return amplitude and lag from joint to joint of the angles (frames, joints), rad."""
    design = np.column_stack([np.sin(phase), np.cos(phase), np.ones_like(phase)])
    sine, cosine, _ = np.linalg.lstsq(design, angle, rcond=None)[0]
    turned = np.unwrap(np.arctan2(cosine, sine))
    return float(np.hypot(sine, cosine).mean()), float(np.diff(turned).mean())
