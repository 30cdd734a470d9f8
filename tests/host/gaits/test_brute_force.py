"""Least power of random robots, on every ground, within limits, against grids ever smaller."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
import serpenoid as sn
from gaits.robots import between

COSTS = ("power", "abs_power", "positive_power")
LIMITS = ("none", "joint angle", "servo speed", "lowest rate", "highest rate")
LEVELS = 6  # grids, each a third as wide as the one before


@dataclass(frozen=True)
class Wish:
    """Hold what is asked for."""

    robot: sn.Robot
    ground: sn.Ground
    speed_m_s: float
    cost: str
    limits: sn.GaitLimits = sn.GaitLimits()  # noqa: RUF009


def cheapest_w(wish: Wish, alphas: Any, betas: Any, rates: Any) -> float | None:
    """Return the least power of a grid and of smaller ones about its best, W; no search.

    Wherever a shape passes the speed, rate and power lie on straight lines in log-log.
    """
    limits, least = wish.limits, math.inf
    for _ in range(LEVELS):
        alphas = alphas[alphas <= limits.joint_angle_rad]
        axes = {"alpha_rad": alphas, "beta_rad": betas, "omega_rad_s": rates}
        grid = sn.sweep(wish.robot, wish.ground, **axes, rtol=1e-4)
        with np.errstate(all="ignore"):
            miss = np.log(np.where(grid.converged, grid.speed_m_s, np.nan) / wish.speed_m_s)
            cost = np.log(getattr(grid, f"{wish.cost}_w"))
            part = miss[..., :-1] / (miss[..., :-1] - miss[..., 1:])
            rate = rates[:-1] * (rates[1:] / rates[:-1]) ** part
            watts = np.exp(cost[..., :-1] + part * np.diff(cost, axis=-1))
        allowed = (
            (part >= 0)
            & (part <= 1)
            & (alphas[:, None, None] * rate <= limits.servo_speed_rad_s)
            & (rate >= limits.omega_low_rad_s)
            & (rate <= limits.omega_high_rad_s)
        )
        watts = np.where(allowed, watts, math.inf)
        i, j, k = np.unravel_index(np.argmin(watts), watts.shape)
        if not watts[i, j, k] < math.inf:
            break
        least = min(least, float(watts[i, j, k]))
        best = (alphas[i], betas[j], float(rate[i, j, k]))
        alphas, betas, rates = (
            middle * np.exp(np.linspace(-1, 1, 7) * math.log(axis[-1] / axis[0]) / 6)
            for middle, axis in zip(best, (alphas, betas, rates), strict=True)
        )
    return least if least < math.inf else None


def random_ground(rng: np.random.Generator, kind: str, weight_n: float) -> sn.Ground:
    ct = between(rng, 0.005, 0.5)
    cn = ct * between(rng, 1.5, 100)
    if kind == "viscous":
        return sn.Ground(ct, cn)
    ft0 = weight_n * between(rng, 0.005, 0.05)
    return sn.Ground(ct, cn, ft0, ft0 * between(rng, 1.5, 15))


def random_limits(name: str, gait: sn.Gait, tighter: float) -> sn.GaitLimits:
    """Return one limit that the best gait without limits breaks, or nearly."""
    w, alpha = gait.omega_rad_s, gait.alpha_rad
    return {
        "none": sn.GaitLimits(),
        "joint angle": sn.GaitLimits(joint_angle_rad=tighter * alpha),
        "servo speed": sn.GaitLimits(servo_speed_rad_s=tighter * alpha * w),
        "lowest rate": sn.GaitLimits(omega_low_rad_s=w / tighter),
        "highest rate": sn.GaitLimits(omega_high_rad_s=w * tighter),
    }[name]


@pytest.mark.parametrize(
    ("kind", "seed"),
    [
        *(("viscous", seed) for seed in range(3)),
        *(pytest.param("viscous", seed, marks=pytest.mark.slow) for seed in range(10, 15)),
        *(pytest.param("dry", seed, marks=pytest.mark.slow) for seed in range(10, 13)),
    ],
)
def test_brute_force_finds_none_cheaper(kind: str, seed: int) -> None:
    """None of 11: a share of 24 % would show in 19 of 20 cases."""
    rng = np.random.default_rng((2005, seed))
    n = int(rng.integers(3, 17 if kind == "viscous" else 9))
    robot = sn.Robot(n, between(rng, 0.03, 1), float(rng.uniform(0.03, 0.15)))
    ground = random_ground(rng, kind, robot.link_mass_kg * 9.81)
    speed, cost = robot.body_length_m * between(rng, 0.03, 0.6), COSTS[seed % 3]
    free = sn.least_power_gait(robot, ground, speed_m_s=speed, cost=cost)
    limits = random_limits(LIMITS[seed % len(LIMITS)], free.gait, between(rng, 0.6, 1.05))
    try:
        best = sn.least_power_gait(robot, ground, speed_m_s=speed, cost=cost, limits=limits)
    except sn.NotConverged:
        best = None
    fine = 1.0 if kind == "viscous" else 0.7
    watts = cheapest_w(
        Wish(robot, ground, speed, cost, limits),
        np.radians(np.geomspace(4, 150, round(14 * fine))),
        np.geomspace(min(0.3, 1.5 / n), 3.05, round(16 * fine)),
        np.geomspace(3, 300, round(22 * fine)) * speed / robot.body_length_m,
    )
    if watts is not None:  # the grid is coarse; the search may still find what it missed
        assert best is not None
        assert best.power_w - best.power_error_w <= watts * (1 + 1e-4)
        assert best.power_w > 0.5 * watts  # the two speak of the same thing
