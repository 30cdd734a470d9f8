"""What a floor's slope does to crawls: known, they are brought to level ground, else doubted."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache, partial

import numpy as np

from ..base.vectors import Array
from ..friction.result import Estimate, FrictionFit
from ..model.drives import Servo
from ..model.gait import Gait
from ..model.ground import Ground
from ..model.robot import Robot
from ..session.gait_run import Crawl
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


def level_run(
    session: Session, fit: FrictionFit, run: Crawl, servo: Servo | None = None, seed: int = 2005
) -> tuple[Crawl, Array]:
    """Return a crawl there or back as on level ground, any other as it is; and the slope's doubt.

    servo: what moves the joints; None: they follow the gait. The doubt is the speeds over this one
    on samples of the slope, (SLOPES,).
    """
    if run.way == "level":
        return run, slope_shares(fit, run, servo, floor_slope(session, {}), seed)
    shares = slope_shares(fit, run, servo, floor_slope(session, fit.nuisances), seed)
    mean = float(shares.mean())
    speed = run.speed_m_s / mean
    sigma = math.hypot(run.speed_sigma_m_s / mean, MODEL_SIGMA * (1.0 - mean) * speed)
    return replace(run, speed_m_s=speed, speed_sigma_m_s=sigma, way="level"), shares / mean


def floor_slope(session: Session, nuisances: Mapping[str, Estimate]) -> Slope:
    """Return the floor's slopes, rad, as pushes told them, or as nobody knows them."""
    unknown = Estimate(0.0, session.setup.instruments.floor_slope_sigma_rad)
    along, across = (
        next((value for name, value in nuisances.items() if name.startswith(part)), unknown)
        for part in ("floor_slope_rad", "floor_slope_across_rad")
    )
    return along, across


def slope_shares(
    fit: FrictionFit, run: Crawl, servo: Servo | None, slope: Slope, seed: int = 2005
) -> Array:
    """Return a crawl's speeds over that on level ground, (SLOPES,), on samples of a floor's slope.

    All crawls of a seed have the same samples. The floor rises ahead of one that goes "back". What
    the mean slope does is found with the servo, whose ripple moves wheels that would stick; how the
    samples differ from it, which costs more runs, with joints that follow.
    """
    sign = -1.0 if run.way == "there" else 1.0
    mean_rad, sigma_rad = sign * np.array(slope).T
    speed_on = partial(_crawl_speed, fit, run.gait, None)
    middle_m_s = max(speed_on(mean_rad), 1e-6)
    shares = np.ones(SLOPES)
    for node, sample in zip(
        NODES, np.random.default_rng(seed).normal(size=(2, SLOPES)), strict=True
    ):
        low, high = (speed_on(mean_rad + k * node * sigma_rad) / middle_m_s for k in (-1.0, 1.0))
        nodes = sample / node.sum()
        shares *= 1.0 + (high - low) / 2 * nodes + ((high + low) / 2 - 1.0) * nodes**2
    if mean_rad.any():
        driven = replace(run.commanded, offset_rad=run.gait.offset_rad) if servo else run.gait
        level_m_s = max(_crawl_speed(fit, driven, servo, np.zeros(2)), 1e-6)
        shares *= _crawl_speed(fit, driven, servo, mean_rad) / level_m_s
    return np.maximum(shares, MIN_SHARE)


def _crawl_speed(fit: FrictionFit, gait: Gait, servo: Servo | None, rise_rad: Array) -> float:
    """Return the mean speed, m/s, of a crawl over ground that rises ahead and to the left, rad.

    The robot turns downhill within some ten seconds, and nobody knows when a reading began.
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
    """Return the mean speed, m/s, and the direction of the first cycle's way, rad."""
    period_s = gait.period_s
    first_cycle, last = (math.ceil(at_s / period_s) for at_s in (FROM_S, TO_S))
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
            dt_s=period_s / STEPS,
            record_every=STEPS // ROWS,
        )
    )
    t_s = period_s * np.arange(first_cycle, last + 2)
    x, y = (np.interp(t_s, run.t_s, way.mean(axis=1)) for way in (run.x_m, run.y_m))
    speeds_m_s = np.hypot(np.diff(x), np.diff(y)) / period_s
    return float(speeds_m_s.mean()), math.atan2(y[1] - y[0], x[1] - x[0])


def slope_in_words(session: Session, fit: FrictionFit) -> str:
    """Return by what the floor of crawls there and back slopes; "" where there are none."""
    if all(run.way == "level" for run in session.kept_crawls):
        return ""
    along, across = (
        f"{math.degrees(angle.value):.2f} ± {math.degrees(angle.sigma):.2f} deg"
        for angle in floor_slope(session, fit.nuisances)
    )
    return (
        "Crawls there and back are shown as they would be on level ground: the floor falls by "
        f"{along} on the way there, and by {across} to the left of it."
    )
