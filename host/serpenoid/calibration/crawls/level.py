"""A session's crawls as they would be on level ground, by the slope that its pushes told."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np

from ...model.drives import Servo
from ...model.gait import Gait
from ...model.ground import Ground
from ...model.robot import Robot
from ...session.session import Session
from ...simulation.scene import Scene
from ...simulation.simulate import simulate
from ..friction_result import Estimate
from ..speeds import scaled, speed
from .data import crawls_by_command

Slope = tuple[Estimate, Estimate]  # of a floor: by what it falls towards "there", and to its left
SLOPE_SIGMA = 0.2  # of what a slope does to a speed: friction is not yet as it will be fitted
_LEAST_SHARE = 0.05  # of the level speed, that a slope leaves
_STEPS, _ROWS = 300, 20  # of a period: time steps, and rows that are kept
_SERVO_STEP_S = 2e-3  # of runs with a servo; a hobby servo's speed is then right to 0.2 %
_OFF = 0.01  # on level ground from the periodic state: then the steps are too long for a servo
_FROM_S, _TO_S = 4.0, 16.0  # behind the gait's start: then a crawl is measured


def floor_slope(session: Session, nuisances: Mapping[str, Estimate]) -> Slope:
    """Return the floor's slopes, rad, as readings told them, or as nobody knows them."""
    unknown = Estimate(0.0, session.setup.floor.slope_sigma_rad)
    along, across = (
        next((value for name, value in nuisances.items() if name.startswith(part)), unknown)
        for part in ("floor_slope_rad", "floor_slope_across_rad")
    )
    return along, across


def is_sloped(session: Session) -> bool:
    """Tell whether a crawl went there or back along a floor."""
    return any(r.way != "level" for r in session.kept_crawls)


def on_level(
    session: Session,
    robot: Robot,
    ground: Ground,
    slope: Slope,
    servo: Servo | None = None,
    amplitude: float = 1.0,
) -> Session:
    """Return the session with crawls that went there or back brought to level ground.

    What the slope does to a crawl is simulated; its doubt is added to the speeds' standard
    deviations. servo, amplitude: what moves the joints, and their amplitude over the commanded one;
    None: joints do what was seen. A weak servo's crawl can feel a slope twice as much.
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
            sign = 1.0 if reading.way == "back" else -1.0
            rises = [Estimate(sign * falls.value, falls.sigma) for falls in slope]
            mean, along, across = _share(robot, ground, gait, rises, servo)
            v = reading.speed_m_s / mean
            doubt = (
                v / mean * math.hypot(math.sqrt(alike) * along, math.sqrt(len(readings)) * across)
            )
            sigma = math.hypot(reading.speed_sigma_m_s / mean, doubt)
            level[reading.number] = replace(
                reading, speed_m_s=v, speed_sigma_m_s=sigma, way="level"
            )
    return replace(
        session,
        gait_runs=tuple(level.get(r.number, r) for r in session.gait_runs),
        further=tuple(level.get(r.number, r) for r in session.further),
    )


def _share(
    robot: Robot, ground: Ground, gait: Gait, rises: Sequence[Estimate], servo: Servo | None
) -> tuple[float, float, float]:
    """Return the speed on a slope over that on level ground, and what that may be off by.

    By the slope along a crawl, and by the one across, which makes crawls there and back alike too
    fast. rises: ahead of the robot, and to its left.
    """
    level = max(sloped_speed(robot, ground, gait, (0.0, 0.0), servo)[0], 1e-6)

    def share(ahead: float, left: float) -> tuple[float, float]:
        """Return it so many sigmas from the likeliest slope, and its scatter over time."""
        along, across = rises
        at_rad = along.value + ahead * along.sigma, across.value + left * across.sigma
        mean, scatter = sloped_speed(robot, ground, gait, at_rad, servo)
        return mean / level, scatter / level

    middle, scatter = share(0.0, 0.0)
    mean, doubts = middle, []
    for way in ((1.0, 0.0), (0.0, 1.0)):
        high, low = share(*way)[0], share(*(-by for by in way))[0]
        even = high + low - 2 * middle
        mean += even / 2
        doubts.append(math.hypot((high - low) / 2, even / math.sqrt(2)))
    mean = max(mean, _LEAST_SHARE)
    return mean, math.hypot(doubts[0], SLOPE_SIGMA * (1.0 - mean)), math.hypot(doubts[1], scatter)


def sloped_speed(
    robot: Robot,
    ground: Ground,
    gait: Gait,
    rises_rad: tuple[float, float],
    servo: Servo | None = None,
) -> tuple[float, float]:
    """Return the speed, m/s, of a crawl on a slope, its mean and scatter while it is measured.

    rises_rad: how the ground rises ahead of the robot as it sets out, and to its left. A robot
    turns downhill within some ten seconds, and nobody knows when a reading began. servo: what moves
    the joints; None: they follow the gait.
    """
    quick = servo is not None and _is_quick(robot, ground, gait, servo)
    _, _, ahead_rad = _crawl(robot, ground, gait, 0.0, 0.0, servo, quick)
    ahead, left = rises_rad
    uphill_rad = math.remainder(ahead_rad + math.atan2(left, ahead), 2 * math.pi)
    return _crawl(robot, ground, gait, math.hypot(ahead, left), uphill_rad, servo, quick)[:2]


@lru_cache(maxsize=512)
def _is_quick(robot: Robot, ground: Ground, gait: Gait, servo: Servo) -> bool:
    """Tell whether steps of _SERVO_STEP_S find the speed of the periodic state on level ground."""
    try:
        stepped = _crawl(robot, ground, gait, 0.0, 0.0, servo, quick=True)[0]
        return abs(stepped / speed(robot, ground, gait, servo) - 1.0) < _OFF
    except ArithmeticError:
        return False


@lru_cache(maxsize=512)
def _crawl(
    robot: Robot,
    ground: Ground,
    gait: Gait,
    incline_rad: float,
    uphill_rad: float,
    servo: Servo | None,
    quick: bool,
) -> tuple[float, float, float]:
    """Return the speed, m/s, its scatter, and the direction of the first cycle's way, rad.

    quick: a servo's crawl by steps of _SERVO_STEP_S, in a quarter of the time.
    """
    period_s = gait.period_s
    before, last = (math.ceil(at_s / period_s) for at_s in (_FROM_S, _TO_S))
    every = math.ceil(period_s / _ROWS / _SERVO_STEP_S) if quick else _STEPS // _ROWS
    moved: dict[str, Any] = (
        {"start": "steady"}
        if servo is None
        else {"drive": "servo", "servo": servo, "method": "rk4" if quick else "nonsmooth"}
    )
    run = simulate(
        Scene(
            robot,
            ground,
            gait,
            duration_s=(last + 1) * period_s,
            incline_rad=incline_rad,
            incline_direction_rad=uphill_rad,
            dt_s=period_s / _ROWS / every,
            record_every=every,
            **moved,
        )
    )
    t_s = period_s * (before + np.arange(last + 2 - before))
    x, y = (np.interp(t_s, run.t_s, way.mean(axis=1)) for way in (run.x_m, run.y_m))
    speeds_m_s = np.hypot(np.diff(x), np.diff(y)) / period_s
    direction_rad = math.atan2(y[1] - y[0], x[1] - x[0])
    return float(speeds_m_s.mean()), float(speeds_m_s.std()), direction_rad
