"""How fast the lab's own robot crawls in a gait, its joints' errors and all."""

from __future__ import annotations

import numpy as np

from ..model.gait import Gait
from .floor import Floor
from .robot import LabRobot

SETTLE_CYCLES, CYCLES, SETTLE_S = 3, 4, 6.0
FRAMES = 1000  # a cycle: between them joints move in straight lines, as they would not


def crawl_speed(robot: LabRobot, gait: Gait, *, slope_rad: float = 0.0) -> float:
    """Return the way of a cycle over its time once the gait repeats, m/s.

    The robot may go in a curve, as one whose joints stand off does; slope_rad rises ahead of it.
    """
    period_s = gait.period_s
    before = max(SETTLE_CYCLES, int(np.ceil(SETTLE_S / period_s)))
    track = Floor(robot, slope_rad, np.pi).crawl(
        gait, (before + CYCLES) * period_s, period_s / FRAMES
    )
    # of servos' frames there is no whole number in a cycle
    at = period_s * (before + np.arange(CYCLES + 1))
    x, y = (np.interp(at, track.t_s, way) for way in (track.x_m, track.y_m))
    return float(np.hypot(np.diff(x), np.diff(y)).mean()) / period_s
