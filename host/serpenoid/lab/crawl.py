"""How fast the lab's own robot crawls in a gait, and what a film of it shows."""

from __future__ import annotations

import numpy as np

from ..base.vectors import Array
from ..model.gait import Gait
from .floor import Floor
from .recording import Camera
from .robot import LabRobot

SETTLE_CYCLES, CYCLES, SETTLE_S = 3, 4, 6.0
FILMED_S = 6.0
FRAMES = 1000  # a cycle: between them joints move in straight lines, as they would not


def crawl_speed(
    robot: LabRobot, gait: Gait, *, slope_rad: float = 0.0, across_rad: float = 0.0
) -> float:
    """Return the way of a cycle over its time once the gait repeats, m/s.

    The robot may go in a curve, as one whose joints stand off does; slope_rad rises ahead of it,
    across_rad falls to its left.
    """
    period_s = gait.period_s
    before = max(SETTLE_CYCLES, int(np.ceil(SETTLE_S / period_s)))
    last_s = (before + CYCLES) * period_s
    track, _ = Floor(robot, -slope_rad, across_rad).driven(gait, last_s, period_s / FRAMES)
    # of servos' frames there is no whole number in a cycle
    t_s = period_s * (before + np.arange(CYCLES + 1))
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

    Whole cycles, FILMED_S at least. A row a picture. slope_rad, across_rad: as of
    `crawl_speed`.
    """
    before = SETTLE_S + SETTLE_CYCLES * gait.period_s
    last = before + gait.period_s * max(3, np.ceil(FILMED_S / gait.period_s))
    floor = Floor(robot, -slope_rad, across_rad)
    track, joints = floor.driven(gait, last, gait.period_s / FRAMES)
    t = before + np.arange(0.0, last - before, 1 / camera.rate_hz)
    t = t[rng.uniform(size=t.size) >= camera.missing]
    true = np.column_stack([track.x_m, track.y_m, track.heading_rad, joints])
    rows = np.stack([np.interp(t, track.t_s, way) for way in true.T], axis=1)
    rows[:, :2] *= camera.scale
    scatter = [camera.sigma_m, camera.sigma_m, *[camera.sigma_rad] * (rows.shape[1] - 2)]
    return np.column_stack([t - t[0], rows + scatter * rng.normal(size=rows.shape)])
