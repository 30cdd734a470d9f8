"""A gait run with the firmware's controller in the loop: what the board really sends its servos."""

from __future__ import annotations

import math

import numpy as np

from ..base.errors import BadInput
from ..model.gait import Gait
from ..robot.recording.run_gait import LEAST_FRAMES
from ..robot.robot import RobotBoard

RAMP_S = 4.0  # in which a board ramps into a gait
PERIODS = 2


def board_gait(robot: RobotBoard, gait: Gait) -> Gait:
    """Drive a gait and return the one that the board's set-points describe, in true seconds.

    The fixed-point arithmetic, the joints' limits and the clock are in it. The robot goes on
    moving. Raises BadInput where the frames do not hold the gait.
    """
    robot.gait(gait)
    frames = list(robot.frames(RAMP_S + (PERIODS + 0.2) * gait.period_s))
    ramp = round(RAMP_S * 1e6 / robot.hello.frame_us)
    running = [frame for frame in frames[ramp:] if frame.state == "gait"]
    if len(running) < LEAST_FRAMES:
        raise BadInput("the board did not go into the gait; see `serpenoid doctor`")
    phase = np.unwrap([frame.phase_rad for frame in running])
    design = np.column_stack([np.sin(phase), np.cos(phase), np.ones_like(phase)])
    setpoints = np.array([frame.setpoint_rad for frame in running])
    sine, cosine, _ = np.linalg.lstsq(design, setpoints, rcond=None)[0]
    beta = float(np.diff(np.unwrap(np.arctan2(cosine, sine))).mean())
    rate = robot.true_rate_rad_s(gait.omega_rad_s)[0]
    return Gait(float(np.hypot(sine, cosine).mean()), math.remainder(beta, math.tau), rate)
