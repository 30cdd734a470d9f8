"""Rates for wanted speeds on viscous ground: held to single states, to SciPy's search, to order."""

from __future__ import annotations

import math

import numpy as np
import pytest
import serpenoid as sn
from scipy.optimize import minimize
from serpenoid.periodic.at_speed import LowestShape, SpeedSolver

PAPER, VISCOUS = sn.Robot(6, 1.0, 0.12), sn.Ground(0.1, 10.0)
BOUNDS = np.array([-4.0, -2.5]), np.array([0.9, 1.14])


def test_a_state_has_the_speed_and_the_powers_that_a_single_solve_gives() -> None:
    rng = np.random.default_rng(5)
    for _ in range(25):
        robot = sn.Robot(int(rng.integers(3, 13)), float(np.exp(rng.uniform(-4, 0))), 0.08)
        ground = sn.Ground(0.05, 0.05 * float(np.exp(rng.uniform(0.5, 5))))
        shape = rng.uniform([0.1, 0.3], [1.0, 2.5])
        speed = robot.links * 0.08 * float(np.exp(rng.uniform(-3, -0.5)))
        solver = SpeedSolver(robot, ground, "positive_power")
        (found,) = solver.solve(shape[:1], shape[1:], 5.0, speed, math.inf, 1e-7)
        assert found is not None
        one = sn.steady_gait(robot, ground, found.gait, rtol=1e-9)
        assert one.speed_m_s == pytest.approx(speed, rel=1e-7)
        assert one.power_w == pytest.approx(found.power_w, rel=3e-7)
        assert one.positive_power_w == pytest.approx(found.positive_power_w, rel=1e-6)
        far, near = (
            solver.solve(shape[:1], shape[1:], found.omega_rad_s, v, math.inf, 1e-9)[0]
            for v in (speed * 1.001, speed / 1.001)
        )
        assert far is not None
        assert near is not None
        slope = math.log(far.positive_power_w / near.positive_power_w) / (2 * math.log(1.001))
        assert found.slopes[3] == pytest.approx(slope, rel=1e-3)


def test_a_speed_out_of_reach_has_no_state() -> None:
    solver = SpeedSolver(PAPER, VISCOUS, "power")
    shapes = np.array([0.5, 4.0, 0.5]), np.array([1.4, 1.4, 1.4])
    reached, folded, again = solver.solve(*shapes, 4.0, 0.2, math.inf, 1e-7)
    assert reached is not None
    assert again == reached
    assert folded is None  # an amplitude beyond pi
    assert solver.solve(*shapes, 4.0, 0.2, 1.0, 1e-7)[0] is None  # at 3.3 rad/s


@pytest.mark.parametrize("cost", ["power", "abs_power", "positive_power"])
def test_the_lowest_shape_is_where_scipy_finds_it_and_its_tangent_leads_on(cost: str) -> None:
    solver = SpeedSolver(PAPER, VISCOUS, cost)
    start = (-0.9, 0.2, math.log(4.0), 0.1, 0.006)

    def lowest(speed: float) -> LowestShape:
        return solver.lowest(start, BOUNDS, speed, math.inf, 1e-9)

    def value(at: np.ndarray) -> float:
        beta = np.array([math.exp(at[1])])
        alpha = 2 * math.exp(at[0]) * np.sin(beta / 2)
        state = solver.solve(alpha, beta, 4.0, 0.2, math.inf, 1e-9)[0]
        return math.inf if state is None else math.log(getattr(state, f"{cost}_w"))

    found, before, after = lowest(0.2), lowest(0.2 / 1.02), lowest(0.2 * 1.02)
    best = minimize(value, (-0.9, 0.2), method="Nelder-Mead", options={"fatol": 1e-11})
    assert value(np.array(found.shape)) == pytest.approx(best.fun, abs=3e-8)
    assert found.tangent is not None
    moved = np.subtract(after.shape, before.shape) / (2 * math.log(1.02))
    assert found.tangent[:2] == pytest.approx(moved, abs=0.01)


def test_a_lowest_shape_beyond_the_bounds_is_none() -> None:
    solver = SpeedSolver(PAPER, VISCOUS, "power")
    high = np.array([-1.0, 1.14])
    start = (-1.1, 0.2, math.log(4.0), 0.1, 0.006)
    assert solver.lowest(start, (BOUNDS[0], high), 0.2, math.inf, 1e-7).state is None
