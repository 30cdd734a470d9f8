"""The gait of a recorded run: what the board commanded its servos, at the true rate."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from ...model.errors import BadInput
from ...model.gait import Gait
from ..wire.clock import TOLERANCE_PPM
from .stream import load_stream

SETTLED = 0.02  # of the amplitude: while it ramps, frames are left out
LEAST_FRAMES = 20


def recorded_gait(path: Path, joints: int) -> Gait:
    """Return the gait that a recording's set-points describe, its rate in true seconds.

    Ramps are left out: only frames whose phase runs at the usual rate and whose set-points fit one
    sine count. Raises BadInput: no recording, another number of joints, or no gait in it.
    """
    stream = load_stream(path)
    if stream.setpoint_rad.shape[1] != joints:
        raise BadInput(f"{path}: has {stream.setpoint_rad.shape[1]} joints; the robot has {joints}")
    running = np.flatnonzero(stream.state == "gait")
    if len(running) < LEAST_FRAMES:
        raise BadInput(
            f"{path}: holds {len(running)} frames of a gait; record the run that was "
            "filmed, with `serpenoid drive --record`"
        )
    phase = np.unwrap(stream.phase_rad[running])
    angle = stream.setpoint_rad[running]
    design = np.column_stack([np.sin(phase), np.cos(phase), np.ones_like(phase)])
    kept = np.ones(len(running), bool)
    found = np.linalg.lstsq(design, angle, rcond=None)[0]
    for _ in range(8):
        miss = np.abs(angle - design @ found).max(axis=1)
        usual = SETTLED * float(np.hypot(found[0], found[1]).mean())
        better = miss <= max(usual, float(np.quantile(miss[kept], 0.5)))
        if (better == kept).all() or better.sum() < LEAST_FRAMES:
            break
        kept = better
        found = np.linalg.lstsq(design[kept], angle[kept], rcond=None)[0]
    sine, cosine, offset = found
    amplitude = float(np.hypot(sine, cosine).mean())
    lag = float(np.diff(np.unwrap(np.arctan2(cosine, sine))).mean())
    board_s = stream.board_s[running]
    rate = float(np.polyfit(board_s[kept], phase[kept], 1)[0])
    drift = float(np.polyfit(board_s, stream.host_s[running], 1)[0])
    if abs(drift - 1) < 2e-6 * TOLERANCE_PPM:  # else it is a simulated board in a hurry
        rate /= drift
    return Gait(amplitude, math.remainder(lag, math.tau), rate, float(offset.mean()))
