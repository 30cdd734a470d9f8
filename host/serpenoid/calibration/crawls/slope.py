"""What a floor's slope does to a crawl, by the simulation in time."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any

import numpy as np

from ...model.drives import Servo
from ...model.gait import Gait
from ...model.ground import Ground
from ...model.robot import Robot
from ...simulation.scene import Scene
from ...simulation.simulate import simulate

_STEPS, _ROWS = 300, 20  # of a period: time steps, and rows that are kept
_TOLERANCE = 1e-3  # of runs with a servo: the speed is then right to some 0.5 %
_SETTLE_S, _CYCLES = 6.0, 2


def sloped_speed(
    robot: Robot, ground: Ground, gait: Gait, rises_rad: float, servo: Servo | None = None
) -> float:
    """Return the speed, m/s, of a crawl up a slope that rises ahead of it, or falls if negative.

    servo: what moves the joints; None: they follow the gait.
    """
    _, ahead_rad = _crawl(robot, ground, gait, 0.0, 0.0, servo)
    return _crawl(robot, ground, gait, rises_rad, ahead_rad, servo)[0]


@lru_cache(maxsize=256)
def _crawl(
    robot: Robot,
    ground: Ground,
    gait: Gait,
    rises_rad: float,
    ahead_rad: float,
    servo: Servo | None,
) -> tuple[float, float]:
    """Return the speed, m/s, and the direction of the way, rad, once the crawl has settled."""
    period_s = gait.period_s
    before = math.ceil(_SETTLE_S / period_s)
    cycles = _CYCLES if servo is None else 2 * _CYCLES  # frames and gait have no common period
    uphill = ahead_rad + (math.pi if rises_rad < 0.0 else 0.0)
    moved: dict[str, Any] = (
        {"start": "steady", "dt_s": period_s / _STEPS, "record_every": _STEPS // _ROWS}
        if servo is None
        else {"drive": "servo", "servo": servo, "dt_s": period_s / _ROWS, "tolerance": _TOLERANCE}
    )
    run = simulate(
        Scene(
            robot,
            ground,
            gait,
            duration_s=(before + cycles) * period_s,
            incline_rad=abs(rises_rad),
            incline_direction_rad=math.remainder(uphill, 2 * math.pi),
            **moved,
        )
    )
    at = period_s * (before + np.arange(cycles + 1))
    x, y = (np.interp(at, run.t_s, way.mean(axis=1)) for way in (run.x_m, run.y_m))
    speed_m_s = float(np.hypot(np.diff(x), np.diff(y)).mean()) / period_s
    return speed_m_s, math.atan2(y[-1] - y[0], x[-1] - x[0])
