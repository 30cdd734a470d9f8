"""Correct gait runs on a sloping floor to level ground, with the uncertainty from the slope."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache, partial

import numpy as np

from ..base.vectors import Array
from ..friction.result import Estimate, FrictionFit
from ..model.drives import Servo
from ..model.gait import Gait
from ..model.ground import Ground
from ..model.robot import Robot
from ..session.crawls import Crawls
from ..session.gait_run import Crawl
from ..session.session import Session
from ..simulation.scene import Scene
from ..simulation.simulate import simulate

Slope = tuple[Estimate, Estimate]  # Falls of a floor along "there" and to its left, rad.


@dataclass(frozen=True)
class CrawlSteps:
    """Numbers of the simulation of a gait run on a slope.

    steps: time steps of a period. tolerance: relative error of a step; it gives speeds to 1e-4.
    updates_hz: largest simulated rate of a servo's loop. For a loop of 1000 Hz it changes the speed
    by 0.2 %, and takes a third of the time. first_s, last_s: interval after the gait's start in
    which the speed is measured.
    """

    steps: int = 160
    tolerance: float = 1e-5
    updates_hz: float = 250.0
    first_s: float = 4.0
    last_s: float = 16.0


CRAWL = CrawlSteps()
EFFECT_SIGMA = 0.2  # Relative sigma of the predicted effect of a slope, for fitted friction.
MIN_SHARE = 0.01  # Smallest ratio of the speed on a slope to the level speed.
SLOPES = 1024  # Samples of a slope; with 256, `compare` notices wrong predictions less often.
# Deviations of the slope along and across a run, in sigmas, for which the speed is simulated. The
# speed falls steeply uphill and hardly changes downhill. It is interpolated linearly, and constant
# beyond the ends.
NODES = (-3.0, 0.0, 0.5, 1.0, 1.5, 2.0, 3.0), (-3.0, 0.0, 3.0)


def level_run(
    session: Session,
    fit: FrictionFit,
    crawl: Crawls,
    run: Crawl,
    servo: Servo | None = None,
    seed: int = 2005,
) -> tuple[Crawl, Array]:
    """Return a run corrected to level ground, and ratios (SLOPES,) of its speed for sampled slopes.

    A run on level ground is returned as it is. crawl: all runs of its command. servo: the servo
    that moves the joints; None: they follow the gait. The effect of the mean slope is simulated
    with the servo, whose ripple moves wheels that would stick. The sigma of the correction is
    EFFECT_SIGMA times the larger effect of the slope and of the opposite one, because the direction
    of travel is known to some degrees only. The ratios are to the speed on the mean slope.
    """
    is_level = run.way == "level"
    slope = floor_slope(session, {} if is_level else fit.nuisances)
    # The floor falls along "there", and so it rises along "back".
    mean_rad, sigma_rad = (-1.0 if run.way == "there" else 1.0) * np.array(slope).T
    shares = slope_shares(fit, crawl.gait, mean_rad, sigma_rad, seed)
    if is_level:
        return run, shares
    driven = crawl.gait
    if servo:
        driven = replace(crawl.commanded, offset_rad=driven.offset_rad)
        servo = replace(servo, update_hz=min(servo.update_hz, CRAWL.updates_hz))
    level_m_s, slope_m_s, opposite_m_s = (
        max(_crawl_speed(fit, driven, servo, factor * mean_rad), 1e-6)
        for factor in (0.0, 1.0, -1.0)
    )
    speed_ratio = max(slope_m_s / level_m_s, MIN_SHARE) * float(shares.mean())
    largest = max(abs(speed / level_m_s - 1.0) for speed in (slope_m_s, opposite_m_s))
    speed = run.speed_m_s / speed_ratio
    sigma = math.hypot(run.speed_sigma_m_s / speed_ratio, EFFECT_SIGMA * largest * speed)
    return replace(run, speed_m_s=speed, speed_sigma_m_s=sigma), shares / shares.mean()


def floor_slope(session: Session, nuisances: Mapping[str, Estimate]) -> Slope:
    """Return the floor's slopes, rad: fitted to pushes, or else zero with the prior's sigma."""
    unknown = Estimate(0.0, session.setup.instruments.floor_slope_sigma_rad)
    along, across = (
        next((value for name, value in nuisances.items() if name.startswith(part)), unknown)
        for part in ("floor_slope_rad", "floor_slope_across_rad")
    )
    return along, across


def slope_shares(
    fit: FrictionFit, gait: Gait, mean_rad: Array, sigma_rad: Array, seed: int = 2005
) -> Array:
    """Return ratios (SLOPES,) of a gait's speed on sampled slopes to that on the mean slope.

    mean_rad, sigma_rad: (2,), rise of the ground ahead and to the left. The joints are ideal. All
    gaits of a seed have the same samples.
    """
    middle_m_s = max(_crawl_speed(fit, gait, None, mean_rad), 1e-6)
    shares = np.ones(SLOPES)
    normal = np.random.default_rng(seed).normal(size=(2, SLOPES))
    for axis, nodes in enumerate(NODES):
        rises_rad = mean_rad + np.outer(nodes, np.eye(2)[axis] * sigma_rad)
        node_shares = [_crawl_speed(fit, gait, None, rise) / middle_m_s for rise in rises_rad]
        shares *= np.interp(normal[axis], nodes, node_shares)
    return np.maximum(shares, MIN_SHARE)


def _crawl_speed(fit: FrictionFit, gait: Gait, servo: Servo | None, rise_rad: Array) -> float:
    """Return the mean speed, m/s, of a gait run on ground with rises (2,) ahead and to the left.

    It is a mean over time, because the robot turns downhill within some ten seconds, and the start
    of a reading is unknown.
    """
    crawl = partial(_crawl, fit.robot, fit.ground, gait, servo)
    ahead_rad, left_rad = rise_rad.tolist()
    uphill_rad = math.remainder(crawl(0.0, 0.0)[1] + math.atan2(left_rad, ahead_rad), math.tau)
    return crawl(math.hypot(ahead_rad, left_rad), uphill_rad if rise_rad.any() else 0.0)[0]


@lru_cache(maxsize=512)
def _crawl(
    robot: Robot,
    ground: Ground,
    gait: Gait,
    servo: Servo | None,
    incline_rad: float,
    uphill_rad: float,
) -> tuple[float, float]:
    """Return the mean speed, m/s, and the direction of travel in the first cycle, rad."""
    period_s = gait.period_s
    first_cycle, last = (math.ceil(at_s / period_s) for at_s in (CRAWL.first_s, CRAWL.last_s))
    run = simulate(
        Scene(
            robot,
            ground,
            gait,
            drive="servo" if servo else "angle",
            servo=servo,
            start="zero_momentum" if servo else "steady",
            duration_s=(last + 1) * period_s,
            incline_rad=incline_rad,
            incline_direction_rad=uphill_rad,
            method="nonsmooth",
            dt_s=period_s / CRAWL.steps,
            tolerance=CRAWL.tolerance,
            record_every=CRAWL.steps,
        )
    )
    x, y = (way[first_cycle:].mean(axis=1) for way in (run.x_m, run.y_m))  # One row for each cycle.
    speeds_m_s = np.hypot(np.diff(x), np.diff(y)) / period_s
    return float(speeds_m_s.mean()), math.atan2(y[1] - y[0], x[1] - x[0])


def slope_in_words(session: Session, fit: FrictionFit) -> str:
    """Return a sentence on the floor's slope; "" if all gait runs were on level ground."""
    if all(run.way == "level" for run in session.kept_crawls):
        return ""
    along, across = (
        f"{round(math.degrees(angle.value), 3) + 0.0:.3f} ± {math.degrees(angle.sigma):.3f} deg"
        for angle in floor_slope(session, fit.nuisances)
    )
    return (
        "Crawls there and back are shown as they would be on level ground: the floor falls by "
        f"{along} on the way there, and by {across} to the left of it."
    )
