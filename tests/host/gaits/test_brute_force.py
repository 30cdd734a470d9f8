"""Least power of random robots, on every ground, within every limit, against brute force."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
import serpenoid as sn
from gaits.brute_force import Found, Wish, cheapest, exact_table, spring_table
from serpenoid.gaits.limits import peak_torque_nm
from serpenoid.simulation.steady_springs import steady_springs

COSTS = ("power", "abs_power", "positive_power")
LIMITS = ("none", "joint angle", "servo speed", "servo torque", "lowest rate", "highest rate")
OF_2005 = sn.Robot(6, 0.0756, 0.076)
VISCOUS_2005, BINGHAM = (
    sn.Ground.whole_body(6, 0.35, 2.0),
    sn.Ground.whole_body(6, 0.084, 1.2, 0.14, 0.27),
)
Pair = tuple[sn.LeastPower | None, Found | None]


def between(rng: np.random.Generator, low: float, high: float) -> float:
    return float(np.exp(rng.uniform(math.log(low), math.log(high))))


def random_ground(rng: np.random.Generator, kind: str, weight_n: float) -> sn.Ground:
    ct = between(rng, 0.005, 0.5)
    cn = ct * between(rng, 1.5, 100)
    if kind == "viscous":
        return sn.Ground(ct, cn)
    if kind == "ratchet":
        return sn.Ground((ct, ct * between(rng, 2, 10)), cn)
    ft0 = weight_n * between(rng, 0.005, 0.05)
    return sn.Ground(ct, cn, ft0, ft0 * between(rng, 1.5, 15))


def random_limits(rng: np.random.Generator, name: str, free: sn.LeastPower) -> sn.GaitLimits:
    """Return one limit that the best gait without limits breaks, or nearly."""
    gait, tighter = free.gait, between(rng, 0.6, 1.05)
    if name == "joint angle":
        return sn.GaitLimits(joint_angle_rad=tighter * gait.alpha_rad)
    if name == "servo speed":
        return sn.GaitLimits(servo_speed_rad_s=tighter * gait.alpha_rad * gait.omega_rad_s)
    if name == "servo torque":
        most = peak_torque_nm(free.steady.robot, free.steady.ground, gait)
        return sn.GaitLimits(servo_torque_nm=tighter * most)
    if name == "lowest rate":
        return sn.GaitLimits(omega_low_rad_s=gait.omega_rad_s / tighter)
    if name == "highest rate":
        return sn.GaitLimits(omega_high_rad_s=gait.omega_rad_s * tighter)
    return sn.GaitLimits()


def both(kind: str, seed: int) -> Pair:
    """Return what the search and what brute force find for a random robot."""
    rng = np.random.default_rng((2005, seed))
    n = int(rng.integers(3, 17 if kind == "viscous" else 9))
    robot = sn.Robot(n, between(rng, 0.03, 1), float(rng.uniform(0.03, 0.15)))
    ground = random_ground(rng, kind, robot.link_mass_kg * 9.81)
    body = n * robot.link_length_m
    speed, cost = body * between(rng, 0.03, 0.6), COSTS[seed % 3]
    free = sn.least_power_gait(robot, ground, speed_m_s=speed, cost=cost)
    limits = random_limits(rng, LIMITS[seed % len(LIMITS)], free)
    try:
        best = sn.least_power_gait(robot, ground, speed_m_s=speed, cost=cost, limits=limits)
    except sn.NotConverged:
        best = None
    smooth = kind != "dry"
    swings = np.radians(np.geomspace(4, 90, 14 if smooth else 10))
    lags = np.geomspace(min(0.3, 1.5 / n), 3.05, 16 if smooth else 10)
    rates = np.geomspace(3, 300, 22 if smooth else 13) * speed / body
    ends = []
    for direction in (1.0, -1.0) if kind == "ratchet" else (1.0,):
        table = exact_table(robot, ground, cost, 1e-5 if smooth else 1e-3)
        wish = Wish(table, robot, ground, speed, limits, direction)
        found = cheapest(wish, swings, lags, rates, starts=3 if smooth else 2, levels=4)
        ends += [found] if found else []
    return best, min(ends, key=lambda one: one.watts, default=None)


def assert_none_cheaper(best: sn.LeastPower | None, found: Found | None) -> None:
    if found is None:
        return  # the grid is coarse; the search may still find what it missed
    assert best is not None
    assert best.power_w - best.power_error_w <= found.watts * (1 + 1e-6)
    assert best.power_w > 0.5 * found.watts  # the two speak of the same thing


@pytest.mark.parametrize("seed", range(6))
def test_brute_force_finds_none_cheaper(seed: int) -> None:
    assert_none_cheaper(*both("viscous", seed))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "seed"),
    [
        (kind, seed)
        for kind, many in (("viscous", 24), ("dry", 8), ("ratchet", 6))
        for seed in range(10, 10 + many)
    ],
)
def test_brute_force_over_random_robots_finds_none_cheaper(kind: str, seed: int) -> None:
    assert_none_cheaper(*both(kind, seed))


def by_springs(
    robot: sn.Robot,
    ground: sn.Ground,
    speed: float,
    cost: str,
    springs: tuple[float, float],
    **grid: Any,
) -> tuple[sn.LeastPower, Found | None]:
    best = sn.least_power_gait(
        robot,
        ground,
        speed_m_s=speed,
        cost=cost,
        formulation="implicit",
        joint_stiffness_n_m=springs[0],
        joint_damping_n_s_m=springs[1],
    )
    table = spring_table(robot, ground, cost, springs, 3e-3 if ground.dry else 1e-3)
    body = robot.links * robot.link_length_m
    rates = np.geomspace(4, 100, grid.pop("rates", 9)) * speed / body
    swings = np.radians(np.geomspace(9, 64, grid.pop("swings", 6)))
    lags = np.geomspace(0.5, 2.6, grid.pop("lags", 6))
    return best, cheapest(Wish(table, robot, ground, speed), swings, lags, rates, **grid)


@pytest.mark.slow
def test_brute_force_over_springs_finds_none_cheaper() -> None:
    """Springs so soft that the exact model's optimum is far from theirs."""
    robot, ground, springs = sn.Robot(3, 0.4, 0.11), sn.Ground(0.06, 1.1), (60.0, 4.0)
    best, found = by_springs(
        robot,
        ground,
        0.06,
        "positive_power",
        springs,
        rates=5,
        swings=4,
        lags=4,
        starts=1,
        levels=2,
        near=3,
    )
    exact = sn.least_power_gait(robot, ground, speed_m_s=0.06, cost="positive_power")
    assert abs(best.power_w / exact.power_w - 1) > 0.05
    assert found is not None
    assert 0.97 * found.watts < best.power_w <= found.watts * (1 + 1e-4)
    gait = best.gait
    run = steady_springs(
        robot, ground, gait, joint_stiffness_n_m=60.0, joint_damping_n_s_m=4.0, rtol=1e-6
    )
    assert run.speed_m_s == pytest.approx(0.06, rel=3e-4)
    assert run.positive_power_w == pytest.approx(best.power_w, rel=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(8))
def test_brute_force_over_random_springs_finds_none_cheaper(seed: int) -> None:
    """Resonances of the joints from well below the gaits' rates to well above them."""
    rng = np.random.default_rng((51, seed))
    robot = sn.Robot(int(rng.integers(3, 6)), between(rng, 0.05, 1), between(rng, 0.05, 0.15))
    ct = between(rng, 0.02, 0.3)
    ground = sn.Ground(ct, ct * between(rng, 4, 60))
    mode, damping = between(rng, 6, 60), float(rng.uniform(0.2, 0.5))
    mass = robot.link_mass_kg
    speed = robot.links * robot.link_length_m * between(rng, 0.05, 0.5)
    best, found = by_springs(
        robot,
        ground,
        speed,
        COSTS[seed % 3],
        (mass * mode**2, 2 * mass * mode * damping),
        starts=2,
        levels=2,
        near=4,
    )
    assert_none_cheaper(best, found)
