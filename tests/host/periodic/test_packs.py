"""Packs of rates on viscous ground: against the pieces of motion, and their claims."""

from __future__ import annotations

import math

import numpy as np
import pytest
import serpenoid as sn


def wild(rng: np.random.Generator) -> tuple[sn.Robot, sn.Ground, float, float, np.ndarray]:
    """Return a robot of 3 to 40 links, ground with a ratio of 1e-3 to 1e4, a shape, four rates."""

    def between(low: float, high: float) -> float:
        return float(np.exp(rng.uniform(math.log(low), math.log(high))))

    robot = sn.Robot(int(rng.integers(3, 41)), between(0.003, 3), between(0.02, 0.3))
    along = between(1e-3, 30)
    ground = sn.Ground(along, along * between(1e-3, 1e4))
    rates = np.sort(np.exp(rng.uniform(math.log(0.01), math.log(100), 4)))
    return robot, ground, rng.uniform(0.05, 1.5), rng.uniform(0.1, 1.7), rates


def by_pieces(
    robot: sn.Robot, ground: sn.Ground, alpha: float, beta: float, rate: float
) -> sn.Steady:
    """Solve by pieces over the whole cycle: a gait that steers by next to nothing."""
    gait = sn.Gait(alpha, beta, rate, offset_rad=1e-13)
    return sn.steady_gait(robot, ground, gait, rtol=1e-8)


def test_packs_agree_with_pieces_for_wild_robots() -> None:
    rng = np.random.default_rng(4)
    for _ in range(6):
        robot, ground, alpha, beta, rates = wild(rng)
        m = sn.sweep(robot, ground, alpha_rad=alpha, beta_rad=beta, omega_rad_s=rates, threads=1)
        assert m.converged.all()
        for k, rate in enumerate(rates.tolist()):
            s = by_pieces(robot, ground, alpha, beta, rate)
            floor = 1e-4 * rate * robot.links * robot.link_length_m
            assert abs(m.speed_m_s[0, 0, k] - s.speed_m_s) < 1e-7 * max(s.speed_m_s, floor)
            assert m.power_w[0, 0, k] == pytest.approx(s.power_w, rel=1e-6)
            assert m.abs_power_w[0, 0, k] == pytest.approx(s.abs_power_w, rel=3e-6)
