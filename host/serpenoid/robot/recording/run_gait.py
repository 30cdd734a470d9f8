"""The gait of a recorded run: the one that the board was asked for, at the true rate."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np

from ...base.errors import BadInput
from ...model.gait import Gait
from ..wire.clock import BOUNDS
from .stream import Stream, load_stream


def recorded_gait(path: Path, joints: int) -> Gait:
    """Return the gait of a recording in which it ran longest, its rate in true seconds.

    Raises BadInput: no recording, another number of joints, or no gait in it.
    """
    stream = load_stream(path)
    if stream.setpoint_rad.shape[1] != joints:
        raise BadInput(f"{path}: has {stream.setpoint_rad.shape[1]} joints; the robot has {joints}")
    gait = longest_gait(stream)
    drift = float(np.polyfit(stream.board_s, stream.host_s, 1)[0])
    if abs(drift - 1) < 2e-6 * BOUNDS.tolerance_ppm:  # else it is a simulated board in a hurry
        gait = replace(gait, omega_rad_s=gait.omega_rad_s / drift)
    return gait


def longest_gait(stream: Stream) -> Gait:
    """Return the gait that ran for most frames, as it was sent to the board; raise BadInput."""
    obeyed = {line.split(" ")[1] for _, line in stream.reports if line.startswith("ok: ")}
    command = re.compile(r"(#\d+) gait (\S+) (\S+) (\S+)(?: (\S+))? \*.*")
    gaits = [
        (sent_s, match.groups("0"))
        for sent_s, line in stream.sent
        if (match := command.fullmatch(line)) and match[1] in obeyed
    ]
    min_frames = 20
    running_s = stream.host_s[stream.state == "gait"]
    frames = np.histogram(running_s, [*(sent_s for sent_s, _ in gaits), math.inf])[0]
    if frames.max(initial=0) < min_frames:
        raise BadInput(
            f"the recording holds {len(running_s)} frames of a gait that was sent to the board; "
            "record the run, with `serpenoid drive --record`"
        )
    alpha, beta, omega, offset = map(float, gaits[frames.argmax()][1][1:])
    return Gait.degrees(alpha, beta, omega_rad_s=omega, offset_deg=offset)
