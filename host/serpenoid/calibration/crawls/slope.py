"""What a floor's slope does to a crawl, by the simulation in time; joints follow the gait."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from ...model.gait import Gait
from ...model.ground import Ground
from ...model.robot import Robot
from ...simulation.scene import Scene
from ...simulation.simulate import simulate

_STEPS, _ROWS = 300, 20  # of a period: time steps, and rows that are kept
_SETTLE_S, _CYCLES = 6.0, 2


def sloped_speed(robot: Robot, ground: Ground, gait: Gait, rises_rad: float) -> float:
    """Return the speed, m/s, of a crawl up a slope that rises ahead of it, or falls if negative."""
    _, ahead_rad = _crawl(robot, ground, gait, 0.0, 0.0)
    return _crawl(robot, ground, gait, rises_rad, ahead_rad)[0]


@lru_cache(maxsize=64)
def _crawl(
    robot: Robot, ground: Ground, gait: Gait, rises_rad: float, ahead_rad: float
) -> tuple[float, float]:
    """Return the speed, m/s, and the direction of the way, rad, once the crawl has settled."""
    period_s = gait.period_s
    before = math.ceil(_SETTLE_S / period_s)
    uphill = ahead_rad + (math.pi if rises_rad < 0.0 else 0.0)
    run = simulate(Scene(
        robot, ground, gait, start="steady", dt_s=period_s / _STEPS,
        duration_s=(before + _CYCLES) * period_s, record_every=_STEPS // _ROWS,
        incline_rad=abs(rises_rad), incline_direction_rad=math.remainder(uphill, 2 * math.pi),
    ))  # fmt: skip
    at = period_s * (before + np.arange(_CYCLES + 1))
    x, y = (np.interp(at, run.t_s, way.mean(axis=1)) for way in (run.x_m, run.y_m))
    speed_m_s = float(np.hypot(np.diff(x), np.diff(y)).mean()) / period_s
    return speed_m_s, math.atan2(y[-1] - y[0], x[-1] - x[0])
