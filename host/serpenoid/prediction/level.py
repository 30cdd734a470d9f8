"""What a floor's slope does to crawls: known, they are brought to level ground, else doubted."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np

from ..base.vectors import Array
from ..friction.result import Estimate, FrictionFit
from ..model.gait import Gait
from ..model.ground import Ground
from ..model.robot import Robot
from ..session.session import Session
from ..simulation.scene import Scene
from ..simulation.simulate import simulate

Slope = tuple[Estimate, Estimate]  # rad, by which a floor falls towards "there", and to its left
MODEL_SIGMA = 0.2  # relative error of the predicted effect of a slope: friction is a fitted one
MIN_SHARE = 0.05  # least share of the level speed that a slope leaves
STEPS, ROWS = 160, 20  # time steps of a period, and rows that are kept
FROM_S, TO_S = 4.0, 16.0  # after the gait's start: then a crawl is measured
SLOPES = 256  # samples of a floor's slope
NODES = 1.5 * np.eye(2)  # standard deviations of the slope along and across a crawl: between them,
# and up to twice as far, its effect is taken as quadratic


def level_session(
    session: Session, fit: FrictionFit, seed: int = 2005
) -> tuple[Session, dict[int, Array], str]:
    """Return the session with crawls there and back as on level ground, and what is left in doubt.

    That is for each crawl, by its number, the speeds over these on samples of the slope, (SLOPES,);
    and a sentence on the slope, where pushes told it.
    """
    slope, unknown = floor_slope(session, fit.nuisances), floor_slope(session, {})
    level, shares = dict[int, Any](), dict[int, Array]()
    for run in session.kept_crawls:
        if run.way == "level":
            shares[run.number] = slope_shares(fit, run.gait, unknown, seed=seed)
            continue
        share = slope_shares(fit, run.gait, slope, run.way, seed)
        mean = float(share.mean())
        shares[run.number] = share / mean
        speed = run.speed_m_s / mean
        sigma = math.hypot(run.speed_sigma_m_s / mean, MODEL_SIGMA * (1.0 - mean) * speed)
        level[run.number] = replace(run, speed_m_s=speed, speed_sigma_m_s=sigma, way="level")
    new_session = replace(session, readings=tuple(level.get(r.number, r) for r in session.readings))
    return new_session, shares, _in_words(slope) if level else ""


def floor_slope(session: Session, nuisances: Mapping[str, Estimate]) -> Slope:
    """Return the floor's slopes, rad, as pushes told them, or as nobody knows them."""
    unknown = Estimate(0.0, session.setup.instruments.floor_slope_sigma_rad)
    along, across = (
        next((value for name, value in nuisances.items() if name.startswith(part)), unknown)
        for part in ("floor_slope_rad", "floor_slope_across_rad")
    )
    return along, across


def slope_shares(
    fit: FrictionFit, gait: Gait, slope: Slope, way: str = "level", seed: int = 2005
) -> Array:
    """Return a gait's speeds over that on level ground, (SLOPES,), on samples of a floor's slope.

    All gaits of a seed have the same samples. way: the floor rises ahead of one that goes "back".
    """
    along, across = slope
    normal = np.random.default_rng(seed).normal(size=(2, SLOPES))
    sign = -1.0 if way == "there" else 1.0

    def on_slope(along_node: float, left_node: float) -> float:
        rise = along.value + along_node * along.sigma, across.value + left_node * across.sigma
        return _crawl_speed(fit.robot, fit.ground, gait, sign * rise[0], sign * rise[1])

    level_m_s = max(_crawl_speed(fit.robot, fit.ground, gait, 0.0, 0.0), 1e-6)
    middle_m_s = max(on_slope(0.0, 0.0), 1e-6)
    shares = np.full(SLOPES, middle_m_s / level_m_s)
    for node, sample in zip(NODES, normal, strict=True):
        low_m_s, high_m_s = on_slope(*(-node).tolist()), on_slope(*node.tolist())
        size = float(node.sum())
        change = (high_m_s - low_m_s) / 2 * sample / size
        curve = ((high_m_s + low_m_s) / 2 - middle_m_s) * (sample / size) ** 2
        shares *= 1.0 + (change + curve) / middle_m_s
    return np.maximum(shares, MIN_SHARE)


def _crawl_speed(
    robot: Robot, ground: Ground, gait: Gait, along_rad: float, left_rad: float
) -> float:
    """Return the mean speed, m/s, of a crawl over ground that rises ahead and to the left, rad.

    The robot turns downhill within some ten seconds, and nobody knows when a reading began.
    """
    _, direction = _crawl(robot, ground, gait, 0.0, 0.0)
    uphill = math.remainder(direction + math.atan2(left_rad, along_rad), math.tau)
    return _crawl(robot, ground, gait, math.hypot(along_rad, left_rad), uphill)[0]


@lru_cache(maxsize=512)
def _crawl(
    robot: Robot, ground: Ground, gait: Gait, incline_rad: float, uphill_rad: float
) -> tuple[float, float]:
    """Return the mean speed, m/s, and the direction of the first cycle's way, rad."""
    period_s = gait.period_s
    first_cycle, last = (math.ceil(at_s / period_s) for at_s in (FROM_S, TO_S))
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
    t_s = period_s * np.arange(first_cycle, last + 2)
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
