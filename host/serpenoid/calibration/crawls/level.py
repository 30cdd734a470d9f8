"""A session's crawls as they would be on level ground, by the slope that its pushes told."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np

from ...model.drives import Servo
from ...model.gait import Gait
from ...model.ground import Ground
from ...model.robot import Robot
from ...simulation.scene import Scene
from ...simulation.simulate import simulate
from ..friction_result import Estimate
from ..session import Session
from ..speeds import scaled
from .data import crawls_by_command

SLOPE_SIGMA = 0.2  # of what a slope does to a speed: friction is not yet as it will be fitted
_LEAST_SHARE = 0.05  # of the level speed, that a slope leaves
_STEPS, _ROWS = 300, 20  # of a period: time steps, and rows that are kept
_TOLERANCE = 1e-3  # of runs with a servo: the speed is then right to some 0.5 %
_SETTLE_S, _CYCLES = 6.0, 2


def floor_slope(session: Session, nuisances: Mapping[str, Estimate]) -> Estimate:
    """Return the floor's slope, rad, as readings told it, or as nobody knows it."""
    told = [value for name, value in nuisances.items() if name.startswith("floor_slope_rad")]
    return told[0] if told else Estimate(0.0, session.setup.floor.slope_sigma_rad)


def is_sloped(session: Session) -> bool:
    """Tell whether a crawl went there or back along a floor."""
    return any(r.way != "level" for r in session.kept_crawls)


def on_level(
    session: Session,
    robot: Robot,
    ground: Ground,
    slope: Estimate,
    servo: Servo | None = None,
    amplitude: float = 1.0,
) -> Session:
    """Return the session with crawls that went there or back brought to level ground.

    slope: of the floor, which falls towards "there". What it does to a crawl is simulated; its
    doubt is added to the speeds' standard deviations. servo, amplitude: what moves the joints, and
    their amplitude over the commanded one; None: joints do what was seen. A weak servo's crawl can
    feel a slope twice as much.
    """
    level: dict[int, Any] = {}
    for crawl in crawls_by_command(session):
        ways = [run.way for run in crawl.timed]  # runs of a way share what is not known of it
        readings = [(run, crawl.commanded, ways.count(run.way)) for run in crawl.timed]
        readings += [(film, crawl.gait, 1) for film in crawl.films]
        for reading, made, alike in readings:
            if reading.way == "level":
                continue
            gait = made if servo is None else scaled(crawl.commanded, amplitude)
            towards = Estimate((1.0 if reading.way == "back" else -1.0) * slope.value, slope.sigma)
            mean, doubt = _share(robot, ground, gait, towards, servo)
            v = reading.speed_m_s / mean
            sigma = math.hypot(reading.speed_sigma_m_s / mean, math.sqrt(alike) * doubt / mean * v)
            level[reading.number] = replace(
                reading, speed_m_s=v, speed_sigma_m_s=sigma, way="level"
            )
    return replace(
        session,
        gait_runs=tuple(level.get(r.number, r) for r in session.gait_runs),
        further=tuple(level.get(r.number, r) for r in session.further),
    )


def _share(
    robot: Robot, ground: Ground, gait: Gait, rises: Estimate, servo: Servo | None
) -> tuple[float, float]:
    """Return the speed up a slope over that on level ground, its mean and standard deviation."""
    level = max(sloped_speed(robot, ground, gait, 0.0, servo), 1e-6)
    ends = (rises.value + by * rises.sigma for by in (-1.0, 0.0, 1.0))
    low, middle, high = (sloped_speed(robot, ground, gait, s, servo) / level for s in ends)
    odd, even = high - low, high + low - 2 * middle
    mean = max(middle + even / 2, _LEAST_SHARE)
    return mean, math.hypot(odd / 2, even / math.sqrt(2), SLOPE_SIGMA * (1.0 - mean))


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
