"""The gait of a recorded run: what the board commanded its servos, at the true rate."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ...model.errors import BadInput
from ...model.gait import Gait
from ..wire.clock import TOLERANCE_PPM
from .stream import load_stream

SETTLED = 0.02  # of the amplitude: while it ramps, frames are left out
LEAST_FRAMES = 20


def recorded_gait(path: Path, joints: int) -> Gait:
    """Return the gait that a recording's set-points describe, its rate in true seconds.

    Ramps are left out: only frames whose set-points fit one sine count. Raises BadInput: no
    recording, another number of joints, or no gait in it.
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
    phase, board_s = np.unwrap(stream.phase_rad[running]), stream.board_s[running]
    (alpha, beta, offset), kept = settled_sine(phase, stream.setpoint_rad[running])
    rate = float(np.polyfit(board_s[kept], phase[kept], 1)[0])
    drift = float(np.polyfit(board_s, stream.host_s[running], 1)[0])
    if abs(drift - 1) < 2e-6 * TOLERANCE_PPM:  # else it is a simulated board in a hurry
        rate /= drift
    return Gait(alpha, beta, rate, offset)


def settled_sine(
    phase: NDArray[np.float64], angle: NDArray[np.float64]
) -> tuple[tuple[float, float, float], NDArray[np.bool_]]:
    """Return amplitude, lag and offset, rad, of the one sine that most frames fit, and which do.

    phase: (N,), angle: (N, joints), rad.
    """
    design = np.column_stack([np.sin(phase), np.cos(phase), np.ones_like(phase)])
    kept = np.ones(len(phase), bool)
    sine, cosine, offset = np.linalg.lstsq(design, angle, rcond=None)[0]
    for _ in range(8):
        miss = np.abs(angle - design @ [sine, cosine, offset]).max(axis=1)
        usual = SETTLED * float(np.hypot(sine, cosine).mean())
        better = miss <= max(usual, float(np.quantile(miss[kept], 0.5)))
        if (better == kept).all() or better.sum() < LEAST_FRAMES:
            break
        kept = better
        sine, cosine, offset = np.linalg.lstsq(design[kept], angle[kept], rcond=None)[0]
    lag = float(np.diff(np.unwrap(np.arctan2(cosine, sine))).mean())
    amplitude = float(np.hypot(sine, cosine).mean())
    return (amplitude, math.remainder(lag, math.tau), float(offset.mean())), kept
