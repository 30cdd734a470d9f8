"""What a floor's slope does to crawls: known, they are brought to level ground, else doubted."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np

from ..base.vectors import Array
from ..friction.result import Estimate, FrictionFit
from ..model.gait import Gait
from ..model.ground import Ground
from ..model.robot import Robot
from ..session.crawls import crawls_by_command
from ..session.session import Session
from ..simulation.scene import Scene
from ..simulation.simulate import simulate

Slope = tuple[Estimate, Estimate]  # rad, by which a floor falls towards "there", and to its left
MODEL_SIGMA = 0.2  # relative error of the predicted effect of a slope: friction is a fitted one
MIN_SHARE = 0.05  # of the level speed, that a slope leaves
STEPS, ROWS = 160, 20  # of a period: time steps, and rows that are kept
FROM_S, TO_S = 4.0, 16.0  # after the gait's start: then a crawl is measured
NODES = np.array([-2.0, -1.0, 0.0, 1.0, 2.0])  # standard deviations of a slope along a crawl
ACROSS_NODE = 1.5  # standard deviations of a slope across it, whose effect is taken as quadratic


def level_session(session: Session, fit: FrictionFit) -> tuple[Session, str]:
    """Return the session with crawls there and back as on level ground, and the sentence on it.

    The slope is that which pushes told. Its error is added to the speeds' standard deviations.
    """
    if all(crawl.way == "level" for crawl in session.kept_crawls):
        return session, ""
    slope = floor_slope(session, fit.nuisances)
    level: dict[int, Any] = {}
    for crawl in crawls_by_command(session):
        readings = crawl.runs
        for reading in readings:
            if reading.way == "level":
                continue
            sign = 1.0 if reading.way == "back" else -1.0
            rises = [Estimate(sign * falls.value, falls.sigma) for falls in slope]
            share, along, across = _share(fit.robot, fit.ground, reading.gait, rises)
            # readings of one way share the error along it, all readings that across it
            same_way = sum(other.way == reading.way for other in readings)
            doubt = math.hypot(math.sqrt(same_way) * along, math.sqrt(len(readings)) * across)
            speed = reading.speed_m_s / share
            sigma = math.hypot(reading.speed_sigma_m_s, doubt * speed) / share
            level[reading.number] = replace(
                reading, speed_m_s=speed, speed_sigma_m_s=sigma, way="level"
            )
    made = replace(session, readings=tuple(level.get(r.number, r) for r in session.readings))
    return made, _in_words(slope)


def floor_slope(session: Session, nuisances: Mapping[str, Estimate]) -> Slope:
    """Return the floor's slopes, rad, as pushes told them, or as nobody knows them."""
    unknown = Estimate(0.0, session.setup.instruments.floor_slope_sigma_rad)
    along, across = (
        next((value for name, value in nuisances.items() if name.startswith(part)), unknown)
        for part in ("floor_slope_rad", "floor_slope_across_rad")
    )
    return along, across


def unknown_slope(
    robot: Robot, ground: Ground, gaits: Sequence[Gait], sigma_rad: float, count: int, seed: int
) -> Array:
    """Return the speeds over those on level ground, (count, gaits), on floors of unknown slope.

    Along a crawl and across it the slope has this standard deviation, and all gaits have the same.
    """
    along, across = np.random.default_rng(seed).normal(size=(2, count))
    columns = []
    for gait in gaits:
        level = max(_crawl_speed(robot, ground, gait, 0.0, 0.0), 1e-6)
        rises = [_crawl_speed(robot, ground, gait, node * sigma_rad, 0.0) for node in NODES]
        turned = _crawl_speed(robot, ground, gait, 0.0, ACROSS_NODE * sigma_rad) / level
        by_along = np.interp(along, NODES, np.array(rises) / level)
        columns.append(by_along * (1.0 + (turned - 1.0) * (across / ACROSS_NODE) ** 2))
    return np.maximum(np.stack(columns, axis=1), MIN_SHARE)


def _share(
    robot: Robot, ground: Ground, gait: Gait, rises: Sequence[Estimate]
) -> tuple[float, float, float]:
    """Return the speed on a slope over that on level ground, and its errors along and across.

    rises: of the floor ahead of the robot, and to its left.
    """
    along, across = rises
    level = max(_crawl_speed(robot, ground, gait, 0.0, 0.0), 1e-6)

    def at(ahead: float, left: float) -> float:
        rise = along.value + ahead * along.sigma, across.value + left * across.sigma
        return _crawl_speed(robot, ground, gait, *rise) / level

    middle = at(0.0, 0.0)
    errors, mean = [], middle
    for ahead, left in ((1.0, 0.0), (0.0, 1.0)):
        high, low = at(ahead, left), at(-ahead, -left)
        curved = high + low - 2 * middle
        mean += curved / 2
        errors.append(math.hypot((high - low) / 2, curved / math.sqrt(2)))
    mean = max(mean, MIN_SHARE)
    return mean, math.hypot(errors[0], MODEL_SIGMA * (1.0 - mean)), errors[1]


def _crawl_speed(robot: Robot, ground: Ground, gait: Gait, ahead: float, left: float) -> float:
    """Return the mean speed, m/s, of a crawl over ground that rises ahead and to the left, rad.

    The robot turns downhill within some ten seconds, and nobody knows when a reading began.
    """
    _, direction = _crawl(robot, ground, gait, 0.0, 0.0)
    uphill = math.remainder(direction + math.atan2(left, ahead), math.tau)
    return _crawl(robot, ground, gait, math.hypot(ahead, left), uphill)[0]


@lru_cache(maxsize=512)
def _crawl(
    robot: Robot, ground: Ground, gait: Gait, incline_rad: float, uphill_rad: float
) -> tuple[float, float]:
    """Return the mean speed, m/s, and the direction of the first cycle's way, rad."""
    period_s = gait.period_s
    before, last = (math.ceil(at_s / period_s) for at_s in (FROM_S, TO_S))
    run = simulate(
        Scene(
            robot,
            ground,
            gait,
            start="steady",
            duration_s=(last + 1) * period_s,
            incline_rad=incline_rad,
            incline_direction_rad=uphill_rad,
            dt_s=period_s / STEPS,
            record_every=STEPS // ROWS,
        )
    )
    t_s = period_s * np.arange(before, last + 2)
    x, y = (np.interp(t_s, run.t_s, way.mean(axis=1)) for way in (run.x_m, run.y_m))
    speeds_m_s = np.hypot(np.diff(x), np.diff(y)) / period_s
    return float(speeds_m_s.mean()), math.atan2(y[1] - y[0], x[1] - x[0])


def _in_words(slope: Slope) -> str:
    along, across = slope
    sizes = [
        f"{math.degrees(abs(angle.value)):.2f} ± {math.degrees(angle.sigma):.2f} deg"
        for angle in slope
    ]
    ends = "there" if along.value >= 0 else "back", "left" if across.value >= 0 else "right"
    return (
        "Crawls there and back are shown as they would be on level ground: the floor falls by "
        f"{sizes[0]} towards {ends[0]}, and by {sizes[1]} to the {ends[1]} of the way there."
    )
