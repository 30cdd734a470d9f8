"""Numbers drawn for robots, and the speed of one in time."""

from __future__ import annotations

import math

import numpy as np
import serpenoid as sn


def between(rng: np.random.Generator, low: float, high: float) -> float:
    """Draw a number, evenly in its logarithm."""
    return float(np.exp(rng.uniform(math.log(low), math.log(high))))


def run_speed(robot: sn.Robot, ground: sn.Ground, gait: sn.Gait, cycles: int = 12) -> float:
    """Return the speed of the last cycle of a run from rest, m/s: no periodic solver in it."""
    run = sn.simulate(
        sn.Scene(
            robot,
            ground,
            gait,
            start="zero_momentum",
            record_every=400,
            method="nonsmooth" if ground.dry else "rk4",
            dt_s=gait.period_s / 400,
            duration_s=cycles * gait.period_s,
        )
    )
    x, y = run.x_m.mean(axis=1)[-2:], run.y_m.mean(axis=1)[-2:]
    return math.hypot(x[1] - x[0], y[1] - y[0]) / gait.period_s
