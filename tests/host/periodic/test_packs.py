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


FEW_MODES = [  # few nodes for the torque's last modes: robot, ground, shape, rtol
    ((17, 1.92, 0.0756), (0.303, 0.0238), (1.329, 0.3403, 0.03085), 1e-6),
    ((14, 0.006425, 0.03773), (0.01112, 1.572e-4), (1.083, 0.10557, 0.8856), 1e-2),
    ((15, 1.754, 0.07265), (0.001846, 8.994), (1.492, 0.24528, 3.0801), 1e-4),
    ((8, 0.05814, 0.17766), (0.01306, 21.47), (1.157, 0.5165, 15.64), 1e-4),
]


def test_positive_power_claims_what_its_last_modes_may_hide() -> None:
    """The work is off by the torque's modes above those that the nodes resolve."""
    hidden = 0
    for links, friction, shape, rtol in FEW_MODES:
        robot, ground, gait = sn.Robot(*links), sn.Ground(*friction), sn.Gait(*shape)
        s = sn.steady_gait(robot, ground, gait, rtol=rtol)
        truth = sn.steady_gait(robot, ground, gait, rtol=1e-12).positive_power_w
        error = abs(s.positive_power_w - truth)
        assert error <= s.positive_power_error_w, links
        hidden += error > 1e-11 * truth
    assert hidden > 1
