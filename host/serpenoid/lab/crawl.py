"""How fast the lab's own robot crawls in a gait, and what a film of it shows."""

from __future__ import annotations

import numpy as np

from ..base.vectors import Array
from ..model.gait import Gait
from .floor import Floor
from .recording import Camera, filmed
from .robot import LabRobot

SETTLE_S, SETTLE_CYCLES = 6.0, 3  # Time and cycles after which a crawl is steady.
FRAMES = 1000  # Frames a cycle: between them joints move in straight lines, as they would not.


def crawl_speed(
    robot: LabRobot, gait: Gait, *, slope_rad: float = 0.0, across_rad: float = 0.0
) -> float:
    """Return the way of a cycle over its time once the gait repeats, m/s, the mean of four.

    The robot may go in a curve, as one whose joints stand off does; slope_rad rises ahead of it,
    across_rad falls to its left.
    """
    period_s = gait.period_s
    settled = max(SETTLE_CYCLES, int(np.ceil(SETTLE_S / period_s)))
    # A servo's frames are no divisor of a cycle: places are interpolated at whole cycles.
    t_s = period_s * (settled + np.arange(5))
    track, _ = Floor(robot, -slope_rad, across_rad).driven(gait, t_s[-1], period_s / FRAMES)
    x, y = (np.interp(t_s, track.t_s, way) for way in (track.x_m, track.y_m))
    return float(np.hypot(np.diff(x), np.diff(y)).mean()) / period_s


def filmed_crawl(
    robot: LabRobot,
    gait: Gait,
    camera: Camera,
    rng: np.random.Generator,
    slope_rad: float = 0.0,
    across_rad: float = 0.0,
) -> Array:
    """Return what a film shows of a crawl that is steady: t_s, x_m, y_m, heading_rad, joints, rad.

    Whole cycles, three and 6 s at least. A row a picture. slope_rad, across_rad: as of
    `crawl_speed`.
    """
    settled_s = SETTLE_S + SETTLE_CYCLES * gait.period_s
    cycles = max(3, np.ceil(6.0 / gait.period_s))
    end_s = settled_s + gait.period_s * cycles
    track, joints = Floor(robot, -slope_rad, across_rad).driven(gait, end_s, gait.period_s / FRAMES)
    t = settled_s + np.arange(0.0, end_s - settled_s, 1 / camera.rate_hz)
    rows = filmed(t[rng.uniform(size=t.size) >= camera.missing], track, joints, camera, rng)
    rows[:, 0] -= rows[0, 0]
    return rows
